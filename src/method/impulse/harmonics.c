/* Spherical harmonics of order 11 about an axis. */
#include "method/impulse/harmonics.h"

/* 2 pi times the integral of x y_l^0 over 0..1 (Ramamoorthi and Hanrahan 2001). */
const float ty_impulse_cosine_lobe[TY_IMPULSE_TERMS] = {0.886226925f,  1.02332671f, 0.495415912f,   0, -0.110778366f, 0,
                                                        0.0499271346f, 0,           -0.0285469317f, 0, 0.0185080814f};

void ty_impulse_make_recurrence(ty_impulse_recurrence* out) {
    for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m) {
        out->side[m] = m > 0 ? sqrt((2.0 * m + 1) / (2.0 * m)) : 0;
        for (int32_t l = m; l < TY_IMPULSE_TERMS; ++l) {
            const double l2 = (double)l * l, m2 = (double)m * m, below = (l - 1.0) * (l - 1.0);
            const double up = l > m ? sqrt((4 * l2 - 1) / (l2 - m2)) : 0;
            out->up[ty_impulse_pair(l, m)] = up;
            out->down[ty_impulse_pair(l, m)] = l > m + 1 ? up * sqrt((below - m2) / (4 * below - 1)) : 0;
        }
    }
}

void ty_impulse_legendre(const ty_impulse_recurrence* r, double cosine, double sine, double out[TY_IMPULSE_PAIRS]) {
    double diagonal = sqrt(0.25 / TY_IMPULSE_PI);
    for (int32_t m = 0, at = 0; m < TY_IMPULSE_TERMS; ++m) {
        if (m > 0) diagonal *= r->side[m] * sine;
        double before = 0, last = diagonal;
        out[at++] = diagonal;
        for (int32_t l = m + 1; l < TY_IMPULSE_TERMS; ++l, ++at) {
            const double next = r->up[at] * cosine * last - r->down[at] * before;
            before = last;
            last = next;
            out[at] = next;
        }
    }
}

void ty_impulse_zonal(double cosine, double out[TY_IMPULSE_TERMS]) {
    double before = 0, last = 1;
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
        out[l] = sqrt((2 * l + 1) / (4 * TY_IMPULSE_PI)) * last;
        const double next = ((2 * l + 1) * cosine * last - l * before) / (l + 1);
        before = last;
        last = next;
    }
}
