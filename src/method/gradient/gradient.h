/* Gradients that methods make, and the part of their making that does not depend on the method: what cannot be
 * differentiated, the loss on cells, and the adjoint of uncollided light. */
#ifndef TY_METHOD_GRADIENT_GRADIENT_H
#define TY_METHOD_GRADIENT_GRADIENT_H

#include "base/progress.h"
#include "direct/lights/discrete_light.h"
#include "direct/media/coverage.h"
#include "direct/media/medium_gradient.h"
#include "method/volume_method.h"

#include <tyndall/gradient.h>

struct ty_gradient {
    ty_context* context;
    ty_grid_medium* medium;   /* on the cells of uncollided light */
    ty_medium_gradient media; /* by that */
    double (*lights)[3];      /* by a factor of each light */
    int32_t light_count;
};

/* A gradient of zeros for lights of a scene on a medium, which it takes, also after an error. Errors: TY_ERROR_MEMORY.
 */
ty_result ty_gradient_create(const ty_scene* scene, ty_grid_medium* medium, ty_gradient** out);
/* The beginning of ty_METHOD_gradient: takes a caller's def to own, as ty_volume_take_def, and stats to totals, and
 * checks the cells. Fails for scenes with surfaces, media that emit, and, unless `points`, lights that are neither
 * directions nor environments. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_gradient_begin(const ty_scene* scene, const ty_volume_method* method, const void* def, void* own,
                            bool points, const ty_coverage_box* cells, const ty_gradient_stats* stats,
                            ty_gradient_stats* totals);
/* dL/dfluence of a box's cells from that of a caller's: planes of zeros receive it. */
void ty_gradient_spread_weights(const ty_coverage_box* cells, const double* weights, const ty_grid_box* box,
                                float* const planes[3]);

/* Adds to `by_extinction` (planes as of the medium) and to the gradient's lights what a loss with dL/dfluence of
 * uncollided light `weight`, per channel, makes by it. extinction: the planes that attenuate it. Errors:
 * TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_gradient_add_uncollided(ty_gradient* gradient, const ty_scene* scene, const ty_discrete_light_set* sources,
                                     float* const extinction[3], float* const weight[3], float* const by_extinction[3],
                                     ty_part_progress* progress);

#endif
