/* Uncollided light of one point on a grid. */
#ifndef TY_DIRECT_UNCOLLIDED_POINT_LIGHT_H
#define TY_DIRECT_UNCOLLIDED_POINT_LIGHT_H

#include "base/progress.h"
#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"
#include "scene/scene.h"

/* Planes that light is added to. Where `transmittance` is set, its planes (as many as the medium has) receive each
 * cell's mean transmittance; otherwise fluence and, unless NULL, flux are added to. */
typedef struct ty_point_light_target {
    float* const* transmittance;
    int32_t planes; /* of fluence and flux: 3, or 1 for all channels */
    float color[3]; /* intensity for each plane */
    float* const* fluence;
    float* const (*flux)[3];
} ty_point_light_target;

/* extinction: as many planes as the medium has. progress: of this source. Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_point_light_add(const ty_scene_view* scene, const ty_grid_medium* medium, float* const extinction[3],
                             const ty_discrete_light* source, const ty_point_light_target* out,
                             ty_part_progress* progress);

#endif
