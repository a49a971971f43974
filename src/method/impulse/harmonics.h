/* Spherical harmonics of order 11 about an axis. */
#ifndef TY_METHOD_IMPULSE_HARMONICS_H
#define TY_METHOD_IMPULSE_HARMONICS_H

#include "base/constants.h"

#include <math.h>
#include <tyndall/impulse.h>

enum { TY_IMPULSE_PAIRS = TY_IMPULSE_TERMS * (TY_IMPULSE_TERMS + 1) / 2 }; /* pairs of l and m, 0 <= m <= l */

/* Legendre orders of a clamped cosine lobe: of the odd orders only the first is nonzero. */
enum {
    TY_IMPULSE_ORDERS = 11,
    TY_IMPULSE_ORDER_LAST = 18,
    TY_IMPULSE_EMITTED_PAIRS = 82 /* pairs of such an order and an m up to 10 */
};
extern const int32_t ty_impulse_orders[TY_IMPULSE_ORDERS];

/* Pairs are sorted by m, then l. */
static inline int32_t ty_impulse_pair(int32_t l, int32_t m) {
    return m * TY_IMPULSE_TERMS - m * (m - 1) / 2 + l - m;
}

/* Factors of the recurrences P_l = up_l x P_(l-1) - down_l P_(l-2) at fixed m, and P_mm = side_m sin P_(m-1)(m-1). */
typedef struct ty_impulse_recurrence {
    double up[TY_IMPULSE_TERMS][TY_IMPULSE_ORDER_LAST + 1], down[TY_IMPULSE_TERMS][TY_IMPULSE_ORDER_LAST + 1];
    double side[TY_IMPULSE_TERMS];
} ty_impulse_recurrence;

void ty_impulse_make_recurrence(ty_impulse_recurrence* out);
/* Orthonormal associated Legendre functions without the Condon-Shortley phase: y_l^0 for m = 0, and y_l^m over sqrt(2)
 * cos(m phi) for m > 0. sine >= 0. */
void ty_impulse_legendre(const ty_impulse_recurrence* r, double cosine, double sine, double out[TY_IMPULSE_PAIRS]);
/* The same for the orders of a cosine lobe: the last ty_impulse_emitted_orders(m) orders for each m = 0..10. */
void ty_impulse_legendre_emitted(const ty_impulse_recurrence* r, double cosine, double sine,
                                 double out[TY_IMPULSE_EMITTED_PAIRS]);
/* Number of cosine lobe orders of at least m. */
static inline int32_t ty_impulse_emitted_orders(int32_t m) {
    return m < 3 ? TY_IMPULSE_ORDERS - m : (TY_IMPULSE_ORDER_LAST - m) / 2 + 1;
}

/* P_l over y_l^0. */
static inline double ty_impulse_zonal_norm(int32_t l) {
    return sqrt(4 * TY_PI_F64 / (2 * l + 1));
}
/* y_l^0 only: the basis of Eq. 14 and 15 (Dubouchet 2019). */
void ty_impulse_zonal(double cosine, double out[TY_IMPULSE_TERMS]);

/* Coefficient of P_l in max(0, cosine). */
double ty_impulse_cosine_coefficient(int32_t l);
/* Zonal harmonics of max(0, cosine). */
extern const float ty_impulse_cosine_lobe[TY_IMPULSE_TERMS];

#endif
