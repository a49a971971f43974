/* Adjoint of diffuse light: derivatives of a weighted sum of its fluence by the sources and by the media of cells. */
#ifndef TY_SOLVE_DIFFUSION_LIGHT_DIFFUSE_ADJOINT_H
#define TY_SOLVE_DIFFUSION_LIGHT_DIFFUSE_ADJOINT_H

#include "direct/media/medium_gradient.h"
#include "solve/diffusion/adjoint/adjoint.h"
#include "solve/diffusion/light/diffuse_light.h"

typedef struct ty_diffuse_loss {
    const ty_diffuse_light* light; /* without faces, as ty_diffuse_light_solve_between made it of the following */
    const ty_diffusion_def* solver;
    bool reduced;
    const ty_grid_medium* medium; /* without emission */
    float* const* source;         /* per channel, W m^-3 */
    float* const* weight;         /* per channel: dL/dphi of each cell */
    double tolerance;
    double* by_streaming; /* receives the derivative by solver->streaming */
    ty_part_progress* progress;
} ty_diffuse_loss;

/* Adds the derivatives by the medium to `media`, and sets by_source[c] per channel. Channels whose light and weights
 * are multiples of another one's take no solve of their own. stats: of all solves. Errors: TY_ERROR_MEMORY;
 * TY_CANCELLED. */
ty_result ty_diffuse_adjoint(const ty_diffuse_loss* loss, ty_medium_gradient* media, float* const by_source[3],
                             ty_diffusion_adjoint_stats* stats);

#endif
