/* Virtual point lights (VPLs) for light that surfaces reflect. */
#ifndef TY_DIRECT_LIGHTS_VPL_H
#define TY_DIRECT_LIGHTS_VPL_H

#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"

typedef struct ty_vpl_def {
    int32_t count;    /* maximum number of VPLs */
    int32_t texels;   /* strata along a side of ty_vpl_samples, from which the VPLs are clustered */
    double clamp;     /* minimum distance in 1 / r^2, as a fraction of the box's longest side */
    double prefilter; /* exponent of the VPLs' mean cosines */
    int32_t reduced;  /* order of ty_grid_medium_reduce for the extinction towards surfaces; 0: unscaled */
    uint64_t seed;
} ty_vpl_def;

/* 64 VPLs from maps of 128 x 128 texels, clamped within a twentieth of the box. */
static inline ty_vpl_def ty_default_vpl_def(void) {
    return (ty_vpl_def){.count = 64, .texels = 128, .clamp = 0.05, .prefilter = 1, .reduced = 1};
}

/* Virtual point lights for light of directional, point and spot lights that surfaces reflect. Radiosity of surfaces
 * that face the medium's box (for directional lights, within eight of its longest sides) is clustered into def->count
 * VPLs of equal weight (luminance x cos theta / square distance from the medium's center). A VPL stands at the texel
 * nearest to its cluster's mean position, and its mean cosine is (1 - w / N)^prefilter, w / N being the fraction of the
 * sphere that the cluster subtends. *out is freed with ty_discrete_light_set_destroy, also after an error. Errors:
 * TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_vpls_create(const ty_scene* scene, const ty_vpl_def* def, const ty_grid_medium* medium,
                         ty_discrete_light_set* out);

#endif
