/* Virtual point lights: what surfaces send of the light that falls on them. */
#ifndef TY_DIRECT_LIGHTS_VPL_H
#define TY_DIRECT_LIGHTS_VPL_H

#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"

typedef struct ty_vpl_def {
    int32_t count;    /* at most */
    int32_t texels;   /* side of the reflective shadow maps that they are chosen from */
    double clamp;     /* of 1 / r^2: r is at least this part of the box's longest side */
    double prefilter; /* what their mean cosines are raised to */
    int32_t reduced; /* order of ty_grid_medium_reduce for the extinction that surfaces are lit through; 0: all of it */
    uint64_t seed;
} ty_vpl_def;

/* 64 of maps of 128 x 128 texels, held within a twentieth of the box. */
static inline ty_vpl_def ty_default_vpl_def(void) {
    return (ty_vpl_def){.count = 64, .texels = 128, .clamp = 0.05, .prefilter = 1, .reduced = 1};
}

/* Virtual point lights of the scene's surfaces as seen by its directional, point and spot lights, behind the medium.
 * All light that surfaces which face some of the medium's box reflect (of directional lights: within eight of its
 * longest sides) is shared out among them, neighbours together, in equal parts by luminance, cosine and distance; each
 * VPL stands where the surface is nearest to the middle of its part, and its mean cosine is (1 - w / N)^prefilter with
 * w / N the part of the sphere that its share of the surfaces takes, seen from the middle of the medium: bright or far,
 * it is small. *out is freed with ty_discrete_light_set_destroy. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_vpls_create(const ty_scene* scene, const ty_vpl_def* def, const ty_grid_medium* medium,
                         ty_discrete_light_set* out);

#endif
