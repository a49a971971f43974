/* The diffuse light of media on cells: one solve a channel, and the radiance that is made of it. */
#ifndef TY_SOLVE_DIFFUSION_DIFFUSE_LIGHT_H
#define TY_SOLVE_DIFFUSION_DIFFUSE_LIGHT_H

#include "base/progress.h"
#include "direct/field.h"
#include "solve/diffusion/diffusion.h"

typedef struct ty_diffuse_light {
    ty_context* context;
    ty_grid_box box;
    size_t cells;
    bool even;                       /* whether media scatter alike in all directions */
    float* terms[3][TY_FIELD_TERMS]; /* as in ty_source_field */
    bool shared;                     /* whether all channels are the first one's, times color */
    float color[3];
} ty_diffuse_light;

/* Per channel. */
typedef struct ty_diffuse_stats {
    bool converged; /* all */
    int32_t iterations[3], cycles[3];
    double residual[3], work[3], emitted[3], absorbed[3], leaving[3]; /* as in ty_diffusion_stats */
    double bytes; /* that the solver works in, with all channels that are solved side by side */
} ty_diffuse_stats;

/* What source (per channel, W m^-3; the media's emission is added to it) becomes in a medium on the same cells.
 * solver: limiter, boundaries, solver and bounds; cells, coefficients, sources, progress and memory are not looked at.
 * reduced: whether extinction is that of light that scatters aside, sigma_t - g sigma_s; false takes media as
 * isotropic. stats: must be there. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_diffuse_light_solve(const ty_diffusion_def* solver, bool reduced, const ty_grid_medium* medium,
                                 float* const source[3], ty_part_progress* progress, ty_diffuse_light** out,
                                 ty_diffuse_stats* stats);
/* The same from light on other cells of the same box; start may be NULL. */
ty_result ty_diffuse_light_refine(const ty_diffuse_light* start, const ty_diffusion_def* solver, bool reduced,
                                  const ty_grid_medium* medium, float* const source[3], ty_part_progress* progress,
                                  ty_diffuse_light** out, ty_diffuse_stats* stats);
/* A channel's fluence, W m^-2, on finer cells of the box: linear between the middles of the light's. */
void ty_diffuse_light_prolong(const ty_diffuse_light* light, int32_t channel, const int32_t size[3], float* fluence);
void ty_diffuse_light_destroy(ty_diffuse_light* light);

/* The field that it is: its arrays stay the light's. directed: with its direction where media scatter unevenly, or
 * always (for surfaces). */
ty_source_field ty_diffuse_light_field(const ty_diffuse_light* light, bool directed);

#endif
