/* The result of a solve, the state of a running solve, and its options. */
#ifndef TY_METHOD_LPV_JOB_H
#define TY_METHOD_LPV_JOB_H

#include "base/progress.h"
#include "direct/shadow/shadow_hierarchy.h"
#include "method/lpv/extended/extended_lights.h"
#include "method/lpv/lattice/lattice.h"
#include "option/option.h"
#include "scene/surfaces/ray_counter.h"

/* A directional, point or spot light and its maps. */
typedef struct ty_lpv_light {
    const ty_light_view* light;
    const ty_rsm* rsm;                /* reflective shadow map for injection */
    const ty_rsm* shadow_map;         /* of higher resolution, for images; may be the same map */
    ty_rsm *own_rsm, *own_shadow_map; /* the traced ones, owned; NULL: a caller's map */
    ty_shadow_hierarchy* hierarchy;   /* of shadow_map */
} ty_lpv_light;

struct ty_lpv {
    ty_context* context;
    ty_lattice* lattices[TY_LPV_CASCADES_MAX]; /* finest first */
    int32_t count;
    ty_lpv_light* sources; /* one per directional, point and spot light of the scene */
    int32_t source_count;
    size_t source_capacity;
    ty_extended_lights* extended; /* the other lights; NULL: none */
    ty_grid_medium* medium;       /* fine cells; NULL: vacuum */
    ty_reduced_media reduced;     /* of medium, through which the light of lights comes; mode links */
};

typedef struct ty_lpv_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_lpv_def* def;
    ty_part_progress progress;
    ty_lpv* light;
    ty_ray_counter counter;
    ty_lpv_stats stats;
} ty_lpv_job;

/* A caller's def and its view, in the library's own sizes. */
typedef struct ty_lpv_known {
    ty_lpv_def def;
    ty_lpv_view_def view; /* where def.view points, if the caller gave one */
} ty_lpv_known;

extern const ty_option_table ty_lpv_options;
/* Copies the caller's def to own, checks all ranges, and makes *def point to the copy. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_lpv_take_def(ty_context* context, const ty_lpv_def** def, ty_lpv_known* own);
/* True if def's maps are those of the scene's lights. */
ty_result ty_lpv_check_maps(const ty_scene* scene, const ty_lpv_def* def);

#endif
