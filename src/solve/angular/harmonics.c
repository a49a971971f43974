#include "solve/angular/harmonics.h"

#include <math.h>

/* Functions of order m or -m: `about` (the real or imaginary part of (x + i y)^m) times normalised Legendre functions
 * without their power of the sine, by recurrence in l. */
static void fill_order(double z, int32_t m, int32_t order, int32_t bands, double diagonal, double about, double* y) {
    double before = 0, here = diagonal;
    for (int32_t l = m; l < bands; ++l) {
        y[l * (l + 1) + order] = here * about;
        const double next = l + 1, square = (double)m * m;
        const double factor = sqrt((4 * next * next - 1) / (next * next - square));
        const double back = sqrt(((double)l * l - square) / (4.0 * l * l - 1));
        const double after = factor * (z * here - (l > m ? back * before : 0));
        before = here;
        here = after;
    }
}

void ty_harmonics_at(const double w[3], int32_t bands, double* y) {
    double real = 1, imaginary = 0, diagonal = 0.28209479177387814; /* 1 / (2 sqrt(pi)) */
    for (int32_t m = 0; m < bands; ++m) {
        const double both = m == 0 ? 1 : 1.4142135623730951;
        fill_order(w[2], m, m, bands, diagonal, both * real, y);
        if (m > 0) fill_order(w[2], m, -m, bands, diagonal, both * imaginary, y);
        const double turned = real * w[0] - imaginary * w[1];
        imaginary = real * w[1] + imaginary * w[0];
        real = turned;
        diagonal *= sqrt((2.0 * m + 3) / (2.0 * m + 2));
    }
}
