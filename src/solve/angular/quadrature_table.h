/* Sets of directions that look the same along all axes: what one octant of each is made of. */
#ifndef TY_SOLVE_ANGULAR_QUADRATURE_TABLE_H
#define TY_SOLVE_ANGULAR_QUADRATURE_TABLE_H

#include <stdint.h>

/* A direction, which stands for all its permutations (1, 3 or 6), and the weight of each: an octant's add up to 1. */
typedef struct ty_symmetry_orbit {
    double direction[3];
    double weight;
} ty_symmetry_orbit;

typedef struct ty_octant_quadrature {
    int32_t directions;
    int32_t exact; /* order of harmonics up to which their weighted sums over all octants vanish, but the first's */
    int32_t count; /* of orbits */
    const ty_symmetry_orbit* orbits;
} ty_octant_quadrature;

/* The one whose number of directions is nearest. */
const ty_octant_quadrature* ty_octant_quadrature_near(double directions);

#endif
