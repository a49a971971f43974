/* One cell of the discrete equations: its diffusivity, and its exchange through the faces of the box. */
#ifndef TY_SOLVE_DIFFUSION_CELLS_K_H
#define TY_SOLVE_DIFFUSION_CELLS_K_H

#include "solve/diffusion/limiter.k.h"

/* epsilon of Eq. 35 (Koerner 2014), for sources with rms 1. */
#define TY_CELL_FLOOR 1e-20f
/* Minimum fraction of its fluence that a cell retains per step while D depends on it. */
#define TY_POSITIVITY_FLOOR 0.1f

/* D of Eq. 15 and 33 (Koerner 2014) from the gradient of Eq. 34 (Koerner 2014), with the floors of R of
 * Eq. 35 (Koerner 2014). */
TY_FN float ty_cell_diffusivity(int32_t limiter, float n, float sigma, float phi, float gx, float gy, float gz) {
    const float gradient = ty_maxf(sqrtf(gx * gx + gy * gy + gz * gz), TY_CELL_FLOOR);
    const float sigma_phi = ty_maxf(sigma * phi, TY_CELL_FLOOR);
    return ty_limiter_value(limiter, n, gradient / sigma_phi) / sigma;
}

/* Relative change of D below which the old value is kept: single-precision limiters are no more accurate, and without
 * the deadband residuals of the nonlinear problem stagnate at the single-precision level, 5e-9 times the cells along an
 * axis. */
#define TY_DIFFUSIVITY_DEADBAND 1e-6f

TY_FN float ty_filter_diffusivity_update(float previous, float next) {
    const float change = next - previous;
    return (change < 0.0f ? -change : change) > TY_DIFFUSIVITY_DEADBAND * previous ? next : previous;
}

/* D damped for the Picard iteration: D (1 - lambda (1 - (3 F)^2)); 1 - (3 F)^2 is -R F'(R) / F(R) for Larsen's limiter
 * with n = 2, and close to it for the others. */
TY_FN float ty_damped_diffusivity(float diffusivity, float sigma, float lambda) {
    const float f = ty_minf(3.0f * sigma * diffusivity, 1.0f);
    return diffusivity * (1.0f - lambda * (1.0f - f * f));
}

/* Outflow through a face of the box per unit of fluence, from the half cell in series with the boundary. */
TY_FN float ty_cell_boundary(float a, float b, float diffusivity) {
    return a * diffusivity / (1.0f + b * diffusivity);
}

#endif
