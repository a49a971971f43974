/* Adjoint of discrete ordinates: derivatives of a weighted sum of the moment phi_00 of a solution by its sources and
 * coefficients, exact for the discrete equations with the set-to-zero fix-ups of the solution.
 *
 * A solution is phi = S(q + s phi), with S a sweep: the moments of the radiance that a source makes. With L the sum of
 * weight times phi_00,
 *
 *     dL/dq = y = S^T (weight + s y),   dL/ds_l = sum_m y_lm phi_lm,   dL/dsigma* = -sum_d w_d psi~_d psi_d
 *
 * with psi_d the radiance of the solution along direction d, w_d its weight, and psi~_d the transpose of diamond
 * difference along d applied to the harmonics of weight + s y. Diamond difference is self-adjoint up to direction (cell
 * by cell, diamond.k.h), so that z_lm = (-1)^l y_lm solves z = S' (weight + s z): the solver's own iteration and
 * acceleration, with S' the sweep along opposite directions whose cells have the closed faces of the solution's. */
#ifndef TY_SOLVE_ORDINATES_ADJOINT_H
#define TY_SOLVE_ORDINATES_ADJOINT_H

#include "solve/ordinates/ordinates.h"

typedef struct ty_ordinates_adjoint_stats {
    bool converged;
    int32_t sweeps;
    double change;    /* as of ty_ordinates_stats */
    double imbalance; /* rms of the change of the solution's fluence by one more sweep, relative to its rms */
} ty_ordinates_adjoint_stats;

/* Planes of one number per cell. */
typedef struct ty_ordinates_adjoint_out {
    float* const* source;    /* dL/dq_lm: bands^2 planes */
    float* extinction;       /* dL/dsigma* at constant s_l */
    float* const* scattered; /* dL/ds_l: bands planes */
} ty_ordinates_adjoint_out;

/* def: of the solve, without walls, boundary radiance and a final set; its progress is that of the adjoint. moments:
 * its result, bands^2 planes. weight: dL/dphi_00 of each cell, of any sign. tolerance: bound of stats->change. Errors:
 * TY_ERROR_ARGUMENT (also where
 * cells are diffusive, or sources displaced), TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_ordinates_adjoint(ty_context* context, const ty_ordinates_def* def, const float* const* moments,
                               const float* weight, double tolerance, const ty_ordinates_adjoint_out* out,
                               ty_ordinates_adjoint_stats* stats);

#endif
