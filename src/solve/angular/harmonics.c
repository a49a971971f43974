#include "solve/angular/harmonics.h"

#include "base/constants.h"

#include <math.h>

/* Harmonics of order m or -m: `azimuthal` (real or imaginary part of (x + i y)^m) times normalised Legendre functions
 * without their power of the sine, by recurrence in l. */
static void fill_order(double z, int32_t m, int32_t order, int32_t bands, double diagonal, double azimuthal,
                       double* y) {
    double previous = 0, current = diagonal;
    for (int32_t l = m; l < bands; ++l) {
        y[l * (l + 1) + order] = current * azimuthal;
        const double next = l + 1, square = (double)m * m;
        const double factor = sqrt((4 * next * next - 1) / (next * next - square));
        const double back = sqrt(((double)l * l - square) / (4.0 * l * l - 1));
        const double following = factor * (z * current - (l > m ? back * previous : 0));
        previous = current;
        current = following;
    }
}

void ty_harmonics_at(const double w[3], int32_t bands, double* y) {
    double real = 1, imaginary = 0, diagonal = 1 / TY_SQRT_4PI_F64;
    for (int32_t m = 0; m < bands; ++m) {
        const double normalisation = m == 0 ? 1 : 1.4142135623730951;
        fill_order(w[2], m, m, bands, diagonal, normalisation * real, y);
        if (m > 0) fill_order(w[2], m, -m, bands, diagonal, normalisation * imaginary, y);
        const double next_real = real * w[0] - imaginary * w[1];
        imaginary = real * w[1] + imaginary * w[0];
        real = next_real;
        diagonal *= sqrt((2.0 * m + 3) / (2.0 * m + 2));
    }
}
