/* What a solve leaves behind, and one call on its way through the parts of the method. */
#ifndef TY_METHOD_LPV_JOB_H
#define TY_METHOD_LPV_JOB_H

#include "base/progress.h"
#include "direct/shadow/lit.h"
#include "method/lpv/inject.h"
#include "method/lpv/pixels.h"

/* A light and what it meets first of the surfaces. */
typedef struct ty_lpv_source {
    const ty_light_view* light;
    const ty_light_map* map;   /* reflective */
    const ty_light_map* sharp; /* of more texels; may be the same */
    ty_light_map *own, *finer; /* that were traced; NULL: a caller's */
    ty_lit_map* lit;           /* of sharp */
} ty_lpv_source;

struct ty_lpv {
    ty_context* context;
    const ty_scene* scene;
    ty_lattice* lattices[TY_LPV_CASCADES_MAX]; /* finest first */
    int32_t count;
    ty_lpv_source* sources; /* one per light of the scene */
    int32_t source_count;
    ty_grid_medium* medium; /* fine; NULL: vacuum */
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

/* Fails with the first field that is out of its range. */
ty_result ty_lpv_check(ty_context* context, const ty_lpv_def* def);
/* Whether def's maps are those of the scene's lights. */
ty_result ty_lpv_check_maps(const ty_scene* scene, const ty_lpv_def* def);

/* Maps of all lights. */
ty_result ty_lpv_find_maps(ty_lpv_job* job);
void ty_lpv_free_maps(ty_lpv* light);
/* Blockers of a lattice: the scene's surfaces, or where it has none, what a caller's maps and view see. */
ty_result ty_lpv_find_blockers(ty_lpv_job* job, ty_lattice* lattice);

#endif
