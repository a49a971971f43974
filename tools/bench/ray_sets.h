/* Input of `tyndall bench rays`: a mesh and sets of rays. */
#ifndef TY_BENCH_RAY_SETS_H
#define TY_BENCH_RAY_SETS_H

#include <tyndall/scene.h>

/* Rays of one kind, in order of tracing. */
typedef struct ray_set {
    const char *name, *key; /* for tables, for JSON */
    bool coherent, shadow;
    ty_ray* rays;
    int64_t count;
} ray_set;

enum { RAYS_CAMERA = 0, RAYS_SHADOW = 1, RAYS_SHUFFLED_SHADOW = 2, RAYS_BOUNCE = 3, RAY_SETS = 4 };

/* Adds hills over [-1, 1]^2, 260642 triangles. */
ty_result bench_add_terrain(ty_scene* scene);

/* Camera rays from obliquely above a committed scene, size[0] x size[1] pixels; shadow rays from their hits to a point
 * light, in the same order and shuffled; and bounce rays in random directions, shuffled. */
ty_result bench_make_rays(const ty_scene* scene, const int32_t size[2], ray_set sets[RAY_SETS]);
void bench_free_rays(ray_set sets[RAY_SETS]);

#endif
