/* Real orthonormal spherical harmonics of any band, in the order and with the signs of base/sh.k.h. */
#ifndef TY_SOLVE_ANGULAR_HARMONICS_H
#define TY_SOLVE_ANGULAR_HARMONICS_H

#include <stdint.h>

/* Evaluates the first bands^2 harmonics at a unit vector. */
void ty_harmonics_at(const double w[3], int32_t bands, double* y);

#endif
