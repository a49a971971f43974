/* Direct use of Embree, the baseline of `tyndall bench rays`. */
#ifndef TY_BENCH_EMBREE_H
#define TY_BENCH_EMBREE_H

#include "bench/ray_sets.h"

typedef struct bench_embree bench_embree;

/* The unprocessed hit of a ray. */
typedef struct bench_embree_hit {
    float distance;
    uint32_t geometry, primitive; /* ~0: no hit */
    float u, v;
    float normal[3];
} bench_embree_hit;

/* A scene of the meshes, whose arrays must outlive it; robust: with RTC_SCENE_FLAG_ROBUST. NULL: Embree failed. */
bench_embree* bench_embree_create(const ty_mesh_def* meshes, int32_t count, bool robust, int32_t threads);
void bench_embree_destroy(bench_embree* embree);

/* Traces blocks of rays on all threads, like ty_scene_trace and ty_scene_trace_shadows: shadow rays fill shadowed,
 * others hits. */
void bench_embree_trace(ty_context* context, const bench_embree* embree, const ray_set* set, bench_embree_hit* hits,
                        bool* shadowed);

#endif
