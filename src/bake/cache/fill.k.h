/* Filling of one cell of the light cache. docs/bake.md explains the method. */
#ifndef TY_BAKE_CACHE_FILL_K_H
#define TY_BAKE_CACHE_FILL_K_H

#include "bake/cache/lookup.k.h"
#include "method/path/trace/path.k.h"

#include <stdatomic.h>

/* Sums over the paths of a cell. */
typedef struct ty_cache_sums {
    double radiance[TY_CACHE_KINDS][3];
    double vector[TY_CACHE_KINDS][3][3]; /* [channel][axis]: radiance times the unit direction of incidence */
    double paths;
} ty_cache_sums;

TY_FN void ty_cache_add(ty_cache_sums* sums, int32_t kind, const float radiance[3], ty_vec from) {
    for (int c = 0; c < 3; ++c) {
        double* vector = sums->vector[kind][c];
        sums->radiance[kind][c] += (double)radiance[c];
        vector[0] += (double)(radiance[c] * from.x);
        vector[1] += (double)(radiance[c] * from.y);
        vector[2] += (double)(radiance[c] * from.z);
    }
}

TY_FN double ty_cache_sum(const ty_cache_sums* sums, int32_t kind) {
    return sums->radiance[kind][0] + sums->radiance[kind][1] + sums->radiance[kind][2];
}

/* A point of a cell from its local coordinates, 0..1. */
TY_FN ty_vec ty_cache_point(const ty_cache_view* view, int32_t cell, float x, float y, float z) {
    const float metres = 1.0f / view->per_metre;
    const float i = (float)(cell % view->size[0]), j = (float)(cell / view->size[0] % view->size[1]),
                k = (float)(cell / (view->size[0] * view->size[1]));
    return ty_vec_make(view->lower[0] + metres * (i + x), view->lower[1] + metres * (j + y),
                       view->lower[2] + metres * (k + z));
}

/* One side of a cell: paths whose first ray hits no back face, and paths whose first ray does. */
typedef struct ty_cache_side_sums {
    ty_vec anchor;
    ty_cache_sums front_paths, back_paths;
} ty_cache_side_sums;

/* The sides of the cell being filled. */
typedef struct ty_cache_cell_sums {
    int32_t sides;
    ty_cache_side_sums side[TY_CACHE_SIDES];
} ty_cache_cell_sums;

/* The side a point belongs to; the first point that sees no anchor becomes the anchor of the second side. NULL: neither
 * side. */
TY_FN ty_cache_side_sums* ty_cache_find_side(const ty_accel* mesh, ty_cache_cell_sums* sums, ty_vec point) {
    for (int32_t i = 0; i < sums->sides; ++i)
        if (mesh == NULL || ty_cache_visible(mesh, point, sums->side[i].anchor)) return &sums->side[i];
    if (sums->sides == TY_CACHE_SIDES) return NULL;
    ty_cache_side_sums* side = &sums->side[sums->sides++];
    memset(side, 0, sizeof *side);
    side->anchor = point;
    return side;
}

/* Marks the normal axis of a surface hit in the cell of the hit point. */
TY_FN void ty_cache_mark_surface(const ty_cache_request* request, const ty_hit* hit, ty_vec direction) {
    const ty_cache_view* view = &request->view;
    if (!ty_cache_contains(view, hit->position)) return;
    const ty_vec ng = ty_dot(hit->normal, direction) > 0.0f ? ty_scale(hit->normal, -1.0f) : hit->normal;
    atomic_fetch_or_explicit(&request->surface_axes[ty_cache_cell(view, hit->position)],
                             (uint8_t)(1u << ty_surfel_axis(ng)), memory_order_relaxed);
}

/* One path from a random point of the cell, which counts as its first scattering vertex. Returns the number of rays. */
TY_FN uint64_t ty_cache_sample(const ty_cache_request* request, int32_t cell, uint32_t number,
                               ty_cache_cell_sums* sums) {
    const float factor[3] = {TY_INV_4PI, TY_INV_4PI, TY_INV_4PI};
    const ty_accel* mesh = request->path.scene->mesh;
    ty_path path;
    ty_light_sample sample;
    ty_hit hit;
    float chosen, direct[3], indirect[3];
    ty_path_begin(&path, &request->path, (uint64_t)cell, number);
    const float x = ty_sobol_next(&path.random), y = ty_sobol_next(&path.random), z = ty_sobol_next(&path.random);
    path.origin = ty_cache_point(&request->view, cell, x, y, z);
    path.run = 1;
    ty_cache_side_sums* side = ty_cache_find_side(mesh, sums, path.origin);
    if (side == NULL) return 2;
    const ty_light_view* light = ty_path_choose_light(&path, path.origin, &chosen, &sample);
    if (light != NULL) ty_path_add_vertex_light(&path, light, chosen, &sample, factor, TY_INV_4PI, 0.0f);
    memcpy(direct, path.radiance[TY_PATH_UNCOLLIDED], sizeof direct);
    memset(path.radiance, 0, sizeof path.radiance);
    ty_path_sample_sphere(&path);
    const ty_vec direction = path.direction;
    const bool hit_surface = mesh != NULL && ty_accel_intersect(mesh, path.origin, direction, TY_FLOAT_MAX, &hit),
               back = hit_surface && ty_dot(hit.normal, direction) > 0.0f;
    if (hit_surface) ty_cache_mark_surface(request, &hit, direction);
    const uint64_t rays = 4 + 2 * ty_path_follow(&path);
    ty_cache_sums* sum = back ? &side->back_paths : &side->front_paths;
    for (int c = 0; c < 3; ++c)
        indirect[c] =
            path.radiance[TY_PATH_REFLECTED][c] + path.radiance[TY_PATH_SINGLE][c] + path.radiance[TY_PATH_MULTIPLE][c];
    if (light != NULL) ty_cache_add(sum, TY_CACHE_DIRECT, direct, sample.wi);
    ty_cache_add(sum, TY_CACHE_DIRECT, path.radiance[TY_PATH_UNCOLLIDED], direction);
    ty_cache_add(sum, TY_CACHE_INDIRECT, indirect, direction);
    sum->paths += 1;
    return rays;
}

/* Stores one kind of light of a cell. */
TY_FN void ty_cache_store(const ty_cache_view* view, const ty_cache_sums* sums, int32_t kind, float* out) {
    const double all = ty_cache_sum(sums, kind);
    double axis[3], length = 0;
    for (int c = 0; c < 3; ++c) out[c] = (float)(sums->radiance[kind][c] / sums->paths);
    for (int a = 0; a < 3; ++a) {
        axis[a] = sums->vector[kind][0][a] + sums->vector[kind][1][a] + sums->vector[kind][2][a];
        length += axis[a] * axis[a];
    }
    length = sqrt(length);
    if (view->floats == TY_CACHE_ISOTROPIC || !(length > 0)) return;
    for (int a = 0; a < 3; ++a) out[3 + a] = (float)(axis[a] / length);
    out[6] = (float)fmin(length / all, 1);
    for (int c = 0; c < view->floats - 6 && view->floats == TY_CACHE_COLORED; ++c) {
        const double* vector = sums->vector[kind][c];
        const double along = (vector[0] * axis[0] + vector[1] * axis[1] + vector[2] * axis[2]) / length;
        const double total = sums->radiance[kind][c];
        out[6 + c] = total > 0 ? (float)fmax(-1, fmin(along / total, 1)) : 0.0f;
    }
}

/* Rays that hit back faces and carry no light start inside walls: on a side that lies partly inside, only the other
 * rays count. False: no ray counts. */
TY_FN bool ty_cache_store_side(const ty_cache_view* view, ty_cache_side_sums* side, float* light) {
    ty_cache_sums* all = &side->front_paths;
    if (ty_cache_sum(&side->back_paths, TY_CACHE_DIRECT) + ty_cache_sum(&side->back_paths, TY_CACHE_INDIRECT) > 0) {
        all->paths += side->back_paths.paths;
        for (int32_t k = 0; k < TY_CACHE_KINDS; ++k)
            for (int c = 0; c < 3; ++c) {
                all->radiance[k][c] += side->back_paths.radiance[k][c];
                for (int a = 0; a < 3; ++a) all->vector[k][c][a] += side->back_paths.vector[k][c][a];
            }
    }
    if (!(all->paths > 0)) return false;
    for (int32_t k = 0; k < TY_CACHE_KINDS; ++k) ty_cache_store(view, all, k, light + k * view->floats);
    return true;
}

/* Returns the flags of the cell. */
TY_FN uint8_t ty_cache_fill(const ty_cache_request* request, int32_t cell, uint64_t* rays) {
    const ty_cache_view* view = &request->view;
    const size_t first_float = (size_t)cell * (size_t)(TY_CACHE_KINDS * view->floats);
    ty_cache_cell_sums sums;
    uint8_t flags = 0;
    sums.sides = 0;
    /* Off the exact center, where walls often lie. */
    ty_cache_find_side(NULL, &sums, ty_cache_point(view, cell, 0.513f, 0.507f, 0.491f));
    for (uint32_t i = 0; i < request->paths; ++i) *rays += ty_cache_sample(request, cell, i, &sums);
    for (int32_t i = 0; i < sums.sides; ++i) {
        float* anchor = view->anchor + (size_t)cell * (3 * TY_CACHE_SIDES) + 3 * i;
        anchor[0] = sums.side[i].anchor.x;
        anchor[1] = sums.side[i].anchor.y;
        anchor[2] = sums.side[i].anchor.z;
        if (ty_cache_store_side(view, &sums.side[i], (i == 0 ? view->light : view->second_light) + first_float))
            flags |= (uint8_t)(1 << i);
    }
    return sums.sides > 1 ? flags | TY_CACHE_TEST_VISIBILITY : flags;
}

#endif
