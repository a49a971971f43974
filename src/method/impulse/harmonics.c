/* Spherical harmonics of order 11 about an axis. */
#include "method/impulse/harmonics.h"

#include "base/legendre.k.h"

const int32_t ty_impulse_orders[TY_IMPULSE_ORDERS] = {0, 1, 2, 4, 6, 8, 10, 12, 14, 16, 18};

/* 2 pi times the integral of x y_l^0 over 0..1 (Ramamoorthi and Hanrahan 2001). */
const float ty_impulse_cosine_lobe[TY_IMPULSE_TERMS] = {0.886226925f,  1.02332671f, 0.495415912f,   0, -0.110778366f, 0,
                                                        0.0499271346f, 0,           -0.0285469317f, 0, 0.0185080814f};

void ty_impulse_make_recurrence(ty_impulse_recurrence* out) {
    for (int32_t m = 0; m < TY_IMPULSE_TERMS; ++m) {
        out->side[m] = m > 0 ? sqrt((2.0 * m + 1) / (2.0 * m)) : 0;
        for (int32_t l = m; l <= TY_IMPULSE_ORDER_LAST; ++l) {
            const double l2 = (double)l * l, m2 = (double)m * m, below = (l - 1.0) * (l - 1.0);
            const double up = l > m ? sqrt((4 * l2 - 1) / (l2 - m2)) : 0;
            out->up[m][l] = up;
            out->down[m][l] = l > m + 1 ? up * sqrt((below - m2) / (4 * below - 1)) : 0;
        }
    }
}

void ty_impulse_legendre(const ty_impulse_recurrence* r, double cosine, double sine, double out[TY_IMPULSE_PAIRS]) {
    double diagonal = sqrt(0.25 / TY_PI_F64);
    for (int32_t m = 0, at = 0; m < TY_IMPULSE_TERMS; ++m) {
        if (m > 0) diagonal *= r->side[m] * sine;
        double before = 0, last = diagonal;
        out[at++] = diagonal;
        for (int32_t l = m + 1; l < TY_IMPULSE_TERMS; ++l, ++at) {
            const double next = r->up[m][l] * cosine * last - r->down[m][l] * before;
            before = last;
            last = next;
            out[at] = next;
        }
    }
}

void ty_impulse_legendre_emitted(const ty_impulse_recurrence* r, double cosine, double sine,
                                 double out[TY_IMPULSE_EMITTED_PAIRS]) {
    double diagonal = sqrt(0.25 / TY_PI_F64);
    for (int32_t m = 0, at = 0; m < TY_IMPULSE_TERMS; ++m) {
        if (m > 0) diagonal *= r->side[m] * sine;
        double before = 0, last = diagonal;
        if (m < 3 || m % 2 == 0) out[at++] = diagonal;
        for (int32_t l = m + 1; l <= TY_IMPULSE_ORDER_LAST; ++l) {
            const double next = r->up[m][l] * cosine * last - r->down[m][l] * before;
            before = last;
            last = next;
            if (l == 1 || l % 2 == 0) out[at++] = next;
        }
    }
}

/* (2 l + 1) / 2 times the integral of x P_l over 0..1. */
double ty_impulse_cosine_coefficient(int32_t l) {
    if (l < 2) return l == 0 ? 0.25 : 0.5;
    if (l % 2 == 1) return 0;
    double central = 1; /* l! / (2^l (l/2)!^2) */
    for (int32_t i = 1; i <= l / 2; ++i) central *= (2.0 * i - 1) / (2.0 * i);
    return (l / 2 % 2 == 1 ? 0.5 : -0.5) * (2 * l + 1) * central / ((l + 2.0) * (l - 1.0));
}

void ty_impulse_zonal(double cosine, double out[TY_IMPULSE_TERMS]) {
    double before = 0, last = 1;
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
        out[l] = sqrt((2 * l + 1) / (4 * TY_PI_F64)) * last;
        const double next = ty_legendre_next_f64(l, cosine, last, before);
        before = last;
        last = next;
    }
}
