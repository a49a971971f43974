/* The inputs of one image. */
#ifndef TY_METHOD_LPV_IMAGE_JOB_H
#define TY_METHOD_LPV_IMAGE_JOB_H

#include "method/lpv/extended/extended_lights.h"
#include "method/lpv/image/airlight.h"
#include "method/lpv/lattice/irradiance.h"

typedef struct ty_lpv_image_job {
    const ty_scene* scene;
    const ty_lpv_def* def;                         /* with width and height filled in */
    ty_lpv_light_view light;                       /* propagated light */
    const ty_grid_medium* medium;                  /* fine cells; NULL: vacuum */
    const ty_reduced_media* reduced;               /* through which the light of lights comes */
    const ty_airlight* airlight;                   /* light that scatters towards the eye, of lights through `reduced`;
                                                      NULL: vacuum */
    const ty_airlight* single;                     /* single scattering of lights through the media as they are; NULL:
                                                      that of airlight, or no channel needs it */
    const ty_extended_lights* extended;            /* lights without shadow maps; NULL: none */
    const ty_shadow_hierarchy* const* shadow_maps; /* one per directional, point and spot light */
    int32_t shadow_map_count;
} ty_lpv_image_job;

#endif
