/* Angular quadratures that are symmetric in all axes, one octant each. */
#ifndef TY_SOLVE_ANGULAR_QUADRATURE_TABLE_H
#define TY_SOLVE_ANGULAR_QUADRATURE_TABLE_H

#include <stdint.h>

/* A direction that represents all its distinct permutations (1, 3 or 6), and the weight of each; the weights of an
 * octant sum to 1. */
typedef struct ty_symmetry_orbit {
    double direction[3];
    double weight;
} ty_symmetry_orbit;

typedef struct ty_octant_quadrature {
    int32_t directions;
    int32_t exactness_order; /* order up to which weighted sums of harmonics over all octants vanish, except l = 0 */
    int32_t count;           /* number of orbits */
    const ty_symmetry_orbit* orbits;
} ty_octant_quadrature;

/* The quadrature with the closest number of directions. */
const ty_octant_quadrature* ty_octant_quadrature_near(double directions);

#endif
