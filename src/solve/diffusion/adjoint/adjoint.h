/* Adjoint of the discrete diffusion equation: derivatives of a weighted sum of its fluence by source, extinction and
 * absorption of each cell, the limiter's dependence on the fluence included.
 *
 * With R(phi, p) = 0 the equation of all cells and L the sum of weight times phi,
 *
 *     (dR/dphi)^T lambda = -weight,   dL/dp = lambda^T dR/dp
 *
 * (Giles and Pierce 2000). dR/dphi = C E - A: A is the linear problem at the diffusivity D of the solution, which is
 * symmetric; C = dR/dD, E = dD/dphi. A solve without a limiter with 1 / (3 D) as its extinction applies the inverse of
 * A, which preconditions the generalised minimal residual method (Saad 1993). */
#ifndef TY_SOLVE_DIFFUSION_ADJOINT_ADJOINT_H
#define TY_SOLVE_DIFFUSION_ADJOINT_ADJOINT_H

#include "solve/diffusion/diffusion.h"

typedef struct ty_diffusion_adjoint_stats {
    bool converged;
    int32_t iterations; /* linear solves */
    int32_t cycles;     /* multigrid cycles of them */
    double residual;    /* rms(residual) / rms(weight) of the adjoint equation */
    double imbalance;   /* rms(residual) / rms(source) of the fluence */
} ty_diffusion_adjoint_stats;

/* Arrays of one number per cell. */
typedef struct ty_diffusion_adjoint_out {
    float *source, *extinction, *absorption; /* derivatives of the loss */
    double* streaming;                       /* one number: by the bound of the flux, ty_diffusion_def.streaming */
} ty_diffusion_adjoint_out;

/* def: of the solve, without faces (TY_ERROR_ARGUMENT), and with boundaries that let no light in; its progress is that
 * of the adjoint, stage "adjoint". fluence: its result,
 * W m^-2; weight: dL/dphi. tolerance: bound of stats->residual,
 * or three tenths of the imbalance where that is more. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY;
 * TY_CANCELLED. */
ty_result ty_diffusion_adjoint(ty_context* context, const ty_diffusion_def* def, const float* fluence,
                               const float* weight, double tolerance, const ty_diffusion_adjoint_out* out,
                               ty_diffusion_adjoint_stats* stats);

#endif
