/* Principal ordinates: the parts that all light is taken to come in. A part's mean cosine is a_n. */
#ifndef TY_METHOD_POP_ORDINATE_H
#define TY_METHOD_POP_ORDINATE_H

#include "direct/lights/vpl.h"

#include <tyndall/pop.h>

/* Lights that go through fine cells at most. */
enum { TY_POP_SHARP_MAX = 8 };

/* Whether a light (an index into ty_light_set.lights) goes through fine cells instead of being an ordinate: in a sharp
 * split, the first eight directional, point and spot lights. */
bool ty_pop_is_sharp(const ty_scene* scene, const ty_pop_def* def, int32_t light);

/* All ordinates of a scene but sharp lights and black ones. Directional lights are one each, and so are point and spot
 * lights; area lights, spheres and glowing triangles are points with the cosine's profile (two of them, back to back,
 * where triangles glow on both sides). Environment lights as importance says: a map as ty_pop_importance's, NULL: all
 * alike. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_pop_ordinates_create(const ty_scene* scene, const ty_pop_def* def, const ty_grid_box* box,
                                  const float* importance, ty_discrete_light_set* out);
/* Virtual point lights as options say, Sec. 6: in split mode behind the medium's reduced extinction, as what surfaces
 * are lit by is all light that keeps its direction. */
static inline ty_vpl_def ty_pop_vpl_def(const ty_pop_def* def) {
    return (ty_vpl_def){.count = def->vpls,
                        .texels = def->shadow_texels,
                        .clamp = def->clamp,
                        .prefilter = def->prefilter,
                        .reduced = def->mode == TY_POP_MODE_SPLIT,
                        .seed = def->seed};
}

/* Sec. 5.2, on a grid of 16^3 cells in the part of the camera's frustum that sees the medium's box. Importance goes
 * from the eye as light goes from an ordinate (U, R and S of ty_pop_sweep), to where surfaces end it; what a cell
 * scatters towards the eye of light from a direction counts by the transmittance of that way out, reduced as ordinates'
 * is, and what it turns aside by that of diffusion, 1 / (1 + 3/4 tau). map: TY_POP_IMPORTANCE_WIDTH x _HEIGHT, mean 1
 * over the sphere, turned as an environment of rotation 0; smoothed over about a texel, and where def->history has a
 * map half of it is that. It is updated. All 1 where the camera sees nothing that scatters. medium: a coarse one is
 * quicker, and of a fine one only some cells are looked at. Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_importance_find(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium,
                                 float* map);

#endif
