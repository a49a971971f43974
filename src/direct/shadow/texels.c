/* Tracing the rays of a map's texels in packets. */
#include "direct/shadow/texels.h"

#include "base/context.h"
#include "base/parallel.h"
#include "scene/surfaces/fetch.h"

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

/* A packet is a square block of texels, whose rays are more coherent than those of a row. */
enum { BLOCK = 4 };

/* Packets that are traced before their hits are shaded. */
enum { PACKETS = 8 };

typedef struct packet {
    ty_ray rays[TY_PACKET];
    size_t texels[TY_PACKET];
    int32_t count;
} packet;

typedef struct texel_job {
    const ty_texels* texels;
    ty_ray_counter* counter;
} texel_job;

static void trace_bare(const ty_texels* texels, const packet* rays, int32_t count, double* seconds) {
    float distances[PACKETS][TY_PACKET];
    const double begun = ty_wall_seconds();
    for (int32_t p = 0; p < count; ++p)
        ty_accel_distance_packet(texels->scene->view.mesh, rays[p].rays, rays[p].count, distances[p]);
    *seconds += ty_wall_seconds() - begun;
    for (int32_t p = 0; p < count; ++p)
        for (int32_t i = 0; i < rays[p].count; ++i) {
            const ty_hit hit = {.distance = distances[p][i]};
            if (isfinite(hit.distance)) texels->meet(texels->user, rays[p].texels[i], &rays[p].rays[i], &hit, NULL);
        }
}

static void meet_all(const ty_texels* texels, const packet* rays, const ty_hit hits[TY_PACKET]) {
    for (int32_t i = 0; i < rays->count; ++i) {
        ty_surface_point point;
        if (hits[i].surface < 0) continue;
        ty_surface_evaluate_fetched(&texels->scene->view.surfaces[hits[i].surface], &hits[i],
                                    ty_vec_load(rays->rays[i].direction), &point);
        texels->meet(texels->user, rays->texels[i], &rays->rays[i], &hits[i], &point);
    }
}

static void trace(const ty_texels* texels, const packet* rays, int32_t count, double* seconds) {
    ty_hit hits[PACKETS][TY_PACKET];
    const ty_surface* surfaces = texels->scene->view.surfaces;
    const double begun = ty_wall_seconds();
    for (int32_t p = 0; p < count; ++p)
        ty_accel_intersect_packet(texels->scene->view.mesh, rays[p].rays, rays[p].count, hits[p]);
    *seconds += ty_wall_seconds() - begun;
    ty_surfaces_fetch(surfaces, hits[0], rays[0].count);
    for (int32_t p = 0; p < count; ++p) {
        if (p + 1 < count) ty_surfaces_fetch(surfaces, hits[p + 1], rays[p + 1].count);
        meet_all(texels, &rays[p], hits[p]);
    }
}

static int32_t blocks_along(const ty_texels* texels) {
    return (texels->side + BLOCK - 1) / BLOCK;
}

/* The rays of a block, without texels that need none. */
static void fill_packet(const ty_texels* texels, int32_t face, int32_t left, int32_t top, packet* out) {
    const int32_t side = texels->side;
    out->count = 0;
    for (int32_t y = top; y < top + BLOCK && y < side; ++y)
        for (int32_t x = left; x < left + BLOCK && x < side; ++x) {
            if (!texels->ray(texels->user, face, x, y, &out->rays[out->count])) continue;
            out->texels[out->count++] = ((size_t)face * (size_t)side + (size_t)y) * (size_t)side + (size_t)x;
        }
}

/* Traces BLOCK rows of a face. */
static void trace_rows(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const texel_job* job = user;
    const ty_texels* texels = job->texels;
    const int32_t blocks = blocks_along(texels);
    packet rays[PACKETS];
    int32_t count = 0;
    int64_t traced = 0;
    double seconds = 0;
    for (int32_t block = 0; block < blocks; ++block) {
        fill_packet(texels, (int32_t)(index / blocks), BLOCK * block, BLOCK * (int32_t)(index % blocks), &rays[count]);
        traced += rays[count].count;
        count += rays[count].count > 0;
        if (count < PACKETS && (block + 1 < blocks || count == 0)) continue;
        (texels->bare ? trace_bare : trace)(texels, rays, count, &seconds);
        count = 0;
    }
    ty_ray_counter_add(job->counter, traced, seconds);
}

void ty_texels_trace(const ty_texels* texels, ty_ray_counter* counter) {
    texel_job job = {.texels = texels, .counter = counter};
    ty_parallel_flushed(texels->scene->context, (int64_t)texels->faces * blocks_along(texels), trace_rows, &job);
}
