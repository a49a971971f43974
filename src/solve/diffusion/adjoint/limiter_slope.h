/* Derivatives of the flux limiters by R, in double precision. */
#ifndef TY_SOLVE_DIFFUSION_ADJOINT_LIMITER_SLOPE_H
#define TY_SOLVE_DIFFUSION_ADJOINT_LIMITER_SLOPE_H

#include "solve/diffusion/diffusion.h"

/* F(R), Table 2 (Koerner 2014), and F'(R). */
typedef struct ty_limiter_point {
    double value, slope;
} ty_limiter_point;

ty_limiter_point ty_limiter_at(ty_limiter limiter, double larsen_power, double r);

#endif
