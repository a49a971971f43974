/* Principal ordinates: directions and points by which all light is represented. The mean cosine of one is a_n (Elek
 * 2014). */
#ifndef TY_METHOD_POP_ORDINATE_ORDINATE_H
#define TY_METHOD_POP_ORDINATE_ORDINATE_H

#include "direct/lights/vpl.h"

#include <tyndall/pop.h>

/* Limit of lights on the fine grid. */
enum { TY_POP_FINE_LIGHTS_MAX = 8 };

/* True if a light (an index into ty_light_set.lights) is injected on the fine grid instead of being an ordinate: in
 * split mode with def->fine_lights, the first eight directional, point and spot lights. */
bool ty_pop_uses_fine_grid(const ty_scene* scene, const ty_pop_def* def, int32_t light);

/* Creates all ordinates of a scene, except fine-grid lights and black ones. Directional, point and spot lights are
 * one each. Area lights, spheres and emissive triangles are points with a cosine profile (two, back to back, for
 * two-sided triangles). Environments are sampled by importance: a map as of ty_pop_importance; NULL: uniform.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_pop_ordinates_create(const ty_scene* scene, const ty_pop_def* def, const ty_grid_box* box,
                                  const float* importance, ty_discrete_light_set* out);
/* Virtual point lights by the options, Sec. 6 (Elek 2014). In split mode they are lit through the medium's reduced
 * extinction, since the light in forward lobes reaches surfaces too. */
static inline ty_vpl_def ty_pop_vpl_def(const ty_pop_def* def) {
    return (ty_vpl_def){.count = def->vpls,
                        .texels = def->shadow_texels,
                        .clamp = def->vpl_min_distance,
                        .prefilter = def->prefilter,
                        .reduced = def->mode == TY_POP_MODE_SPLIT,
                        .seed = def->seed};
}

/* Sec. 5.2 (Elek 2014), on a grid of 16^3 cells in the part of the camera's frustum that covers the medium's box.
 * Importance is transported from the eye as light is from an ordinate (U, R and S of ty_pop_sweep), up to the first
 * surface. Scattering of a cell towards the eye is weighted by the transmittance along the light's direction, with
 * the ordinates' reduced extinction; light scattered out of the lobe by that of diffusion, 1 / (1 + 3/4 tau). map:
 * TY_POP_IMPORTANCE_WIDTH x _HEIGHT, mean 1 over the sphere, oriented as an environment of rotation 0, smoothed over
 * about a texel; averaged with the map in def->history if there is one, which is updated. All 1 if no scattering
 * medium is visible. medium: a coarse one is faster; a fine one is sampled at some cells only. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_pop_importance_find(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium,
                                 float* map);

#endif
