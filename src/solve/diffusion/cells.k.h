/* One cell of the discrete equations: how strongly it diffuses, and what it exchanges with its six neighbours. */
#ifndef TY_SOLVE_DIFFUSION_CELLS_K_H
#define TY_SOLVE_DIFFUSION_CELLS_K_H

#include "solve/diffusion/limiter.k.h"

/* epsilon of Eq. 35, where sources have an rms of 1. */
#define TY_CELL_FLOOR 1e-20f
/* The least share of its fluence that a step may leave a cell when D depends on it. */
#define TY_POSITIVITY_FLOOR 0.1f

/* D (Eq. 33) from the gradient (Eq. 34), with the floors of Eq. 35. */
TY_FN float ty_cell_diffusivity(int32_t limiter, float n, float sigma, float phi, float gx, float gy, float gz) {
    const float gradient = ty_maxf(sqrtf(gx * gx + gy * gy + gz * gz), TY_CELL_FLOOR);
    const float thick = ty_maxf(sigma * phi, TY_CELL_FLOOR);
    return ty_limiter_value(limiter, n, gradient / thick) / sigma;
}

/* D moves only by more than limiters in single precision are good to: else residuals of the non-linear problem stall
 * where single precision puts it, at 5e-9 times the cells along an axis. */
#define TY_DIFFUSIVITY_DEADBAND 1e-6f

TY_FN float ty_filter_diffusivity_update(float held, float next) {
    const float change = next - held;
    return (change < 0.0f ? -change : change) > TY_DIFFUSIVITY_DEADBAND * held ? next : held;
}

/* D less a share of what the flux along the gradient does not answer to: -R F'(R) / F(R) of it, which for Larsen's
 * limiter with n = 2 is 1 - (3 F)^2, and for the others about that. */
TY_FN float ty_damped_diffusivity(float diffusivity, float sigma, float share) {
    const float f = ty_minf(3.0f * sigma * diffusivity, 1.0f);
    return diffusivity * (1.0f - share * (1.0f - f * f));
}

/* What leaves through a face of the box per unit of fluence, from the face's half cell in series with its boundary. */
TY_FN float ty_cell_boundary(float a, float b, float diffusivity) {
    return a * diffusivity / (1.0f + b * diffusivity);
}

#endif
