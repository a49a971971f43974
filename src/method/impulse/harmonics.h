/* Spherical harmonics of order 11 about an axis. */
#ifndef TY_METHOD_IMPULSE_HARMONICS_H
#define TY_METHOD_IMPULSE_HARMONICS_H

#include "base/constants.h"

#include <math.h>
#include <tyndall/impulse.h>

enum { TY_IMPULSE_PAIRS = TY_IMPULSE_TERMS * (TY_IMPULSE_TERMS + 1) / 2 }; /* of l and m, 0 <= m <= l */

/* Legendre polynomials that a cosine lobe is a series of: odd ones but the first have no share. */
enum {
    TY_IMPULSE_ORDERS = 11,
    TY_IMPULSE_ORDER_LAST = 18,
    TY_IMPULSE_SENT = 82 /* pairs of an order and an m up to 10 that it has */
};
extern const int32_t ty_impulse_orders[TY_IMPULSE_ORDERS];

/* Pairs are sorted by m, then l. */
static inline int32_t ty_impulse_pair(int32_t l, int32_t m) {
    return m * TY_IMPULSE_TERMS - m * (m - 1) / 2 + l - m;
}

/* Recurrences' factors: P_l = up_l x P_(l-1) - down_l P_(l-2) at fixed m, and P_mm = side_m sin P_(m-1)(m-1). */
typedef struct ty_impulse_recurrence {
    double up[TY_IMPULSE_TERMS][TY_IMPULSE_ORDER_LAST + 1], down[TY_IMPULSE_TERMS][TY_IMPULSE_ORDER_LAST + 1];
    double side[TY_IMPULSE_TERMS];
} ty_impulse_recurrence;

void ty_impulse_make_recurrence(ty_impulse_recurrence* out);
/* Orthonormal associated Legendre functions without the Condon-Shortley phase: y_l^0 for m = 0, and y_l^m over
 * sqrt(2) cos(m phi) for the others. sine >= 0. */
void ty_impulse_legendre(const ty_impulse_recurrence* r, double cosine, double sine, double out[TY_IMPULSE_PAIRS]);
/* The same of the orders of a cosine lobe: of each m = 0..10, ty_impulse_sent(m) of them, the last ones. */
void ty_impulse_legendre_sent(const ty_impulse_recurrence* r, double cosine, double sine, double out[TY_IMPULSE_SENT]);
/* How many orders there are of at least m. */
static inline int32_t ty_impulse_sent(int32_t m) {
    return m < 3 ? TY_IMPULSE_ORDERS - m : (TY_IMPULSE_ORDER_LAST - m) / 2 + 1;
}

/* y_l^0 alone. */
void ty_impulse_zonal(double cosine, double out[TY_IMPULSE_TERMS]);

/* The share of P_l in max(0, cosine). */
double ty_impulse_cosine_share(int32_t l);
/* Zonal harmonics of max(0, cosine). */
extern const float ty_impulse_cosine_lobe[TY_IMPULSE_TERMS];

#endif
