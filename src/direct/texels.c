/* Texels' rays, in packets. */
#include "direct/texels.h"

#include "base/context.h"
#include "base/parallel.h"
#include "scene/fetch.h"

ty_result ty_texels_check_light(const ty_scene* scene, const char* what, int32_t light) {
    const ty_light_set* lights = &scene->view.lights;
    const int32_t kind = light >= 0 && light < lights->count ? lights->lights[light].kind : -1;
    if (kind == TY_KIND_DIRECTIONAL || kind == TY_KIND_POINT || kind == TY_KIND_SPOT) return TY_OK;
    return ty_fail(scene->context, TY_ERROR_ARGUMENT, "%s: light %d is not a directional, point or spot light", what,
                   light);
}

void ty_texels_extent(ty_vec axis, const double lower[3], const double upper[3], double range[2]) {
    const double along[3] = {(double)axis.x, (double)axis.y, (double)axis.z};
    range[0] = range[1] = 0;
    for (int a = 0; a < 3; ++a) {
        range[0] += along[a] * (along[a] > 0 ? lower[a] : upper[a]);
        range[1] += along[a] * (along[a] > 0 ? upper[a] : lower[a]);
    }
}

/* ---- packets ---- */

/* A packet is a block of texels, whose rays are closer together than those of a row. */
enum { BLOCK = 4 };

typedef struct packet {
    ty_ray rays[TY_PACKET];
    size_t texels[TY_PACKET];
    int32_t count;
} packet;

typedef struct texel_job {
    const ty_texels* texels;
    ty_ray_counter* counter;
} texel_job;

static void trace_bare(const ty_texels* texels, const packet* rays, double* seconds) {
    float distances[TY_PACKET];
    const double begun = ty_wall_seconds();
    ty_mesh_distance_packet(texels->scene->view.mesh, rays->rays, rays->count, distances);
    *seconds += ty_wall_seconds() - begun;
    for (int32_t i = 0; i < rays->count; ++i) {
        const ty_hit hit = {.distance = distances[i]};
        if (isfinite(hit.distance)) texels->meet(texels->user, rays->texels[i], &rays->rays[i], &hit, NULL);
    }
}

static void trace(const ty_texels* texels, const packet* rays, double* seconds) {
    ty_hit hits[TY_PACKET];
    const double begun = ty_wall_seconds();
    ty_mesh_intersect_packet(texels->scene->view.mesh, rays->rays, rays->count, hits);
    *seconds += ty_wall_seconds() - begun;
    ty_surfaces_fetch(texels->scene->view.surfaces, hits, rays->count);
    for (int32_t i = 0; i < rays->count; ++i) {
        ty_surface_point point;
        if (hits[i].surface < 0) continue;
        ty_surface_evaluate(&texels->scene->view.surfaces[hits[i].surface], &hits[i],
                            ty_vec_load(rays->rays[i].direction), &point);
        texels->meet(texels->user, rays->texels[i], &rays->rays[i], &hits[i], &point);
    }
}

static int32_t blocks_along(const ty_texels* texels) {
    return (texels->side + BLOCK - 1) / BLOCK;
}

/* BLOCK rows of a face. */
static void trace_rows(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const texel_job* job = user;
    const ty_texels* texels = job->texels;
    int64_t traced = 0;
    double seconds = 0;
    const int32_t blocks = blocks_along(texels);
    const size_t side = (size_t)texels->side, face = (size_t)(index / blocks), top = BLOCK * (size_t)(index % blocks);
    for (size_t left = 0; left < side; left += BLOCK) {
        packet rays;
        rays.count = 0;
        for (size_t y = top; y < top + BLOCK && y < side; ++y)
            for (size_t x = left; x < left + BLOCK && x < side; ++x) {
                if (!texels->ray(texels->user, (int32_t)face, (int32_t)x, (int32_t)y, &rays.rays[rays.count])) continue;
                rays.texels[rays.count++] = (face * side + y) * side + x;
            }
        if (rays.count == 0) continue;
        if (texels->bare)
            trace_bare(texels, &rays, &seconds);
        else
            trace(texels, &rays, &seconds);
        traced += rays.count;
    }
    ty_ray_counter_add(job->counter, traced, seconds);
}

void ty_texels_trace(const ty_texels* texels, ty_ray_counter* counter) {
    texel_job job = {.texels = texels, .counter = counter};
    ty_parallel_flushed(texels->scene->context, (int64_t)texels->faces * blocks_along(texels), trace_rows, &job);
}
