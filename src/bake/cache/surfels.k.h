/* Surfels of one cell: light scattered by media on its surfaces, from paths over surfaces through media whose light is
 * cached. docs/bake.md explains the method. */
#ifndef TY_BAKE_CACHE_SURFELS_K_H
#define TY_BAKE_CACHE_SURFELS_K_H

#include "bake/cache/fill.k.h"
#include "bake/cache/cached.k.h"

/* Random rays in a cell that search for its surfaces, per path that each surfel should have. */
enum { TY_SURFEL_TRIES = 16 };

typedef struct ty_surfel_sums {
    double light[TY_SURFEL_KINDS][3][TY_SURFEL_TERMS];
    double square[3]; /* sum of squared irradiance */
    double position[3], normal[3], paths;
    ty_vec first, ng; /* position and geometric normal of the first point */
} ty_surfel_sums;

/* Finds a surface point in a cell with a random ray from a random point; false: none. */
TY_FN bool ty_surfel_find(const ty_cache_request* request, int32_t cell, ty_sampler* random, ty_intersection* out,
                          ty_vec* direction) {
    const ty_cache_view* view = &request->view;
    const ty_scene_view* scene = request->path.scene;
    const float x = ty_rng_uniform(random), y = ty_rng_uniform(random), z = ty_rng_uniform(random);
    const float u = ty_rng_uniform(random), v = ty_rng_uniform(random);
    const ty_vec from = ty_cache_point(view, cell, x, y, z);
    *direction = ty_direction_about(ty_vec_make(0, 0, 1), 1.0f - 2.0f * u, v);
    const float max_distance = 1.7320508f / view->per_metre;
    return ty_accel_intersect(scene->mesh, from, *direction, max_distance, &out->hit) &&
           ty_cache_cell(view, out->hit.position) == cell && ty_cache_contains(view, out->hit.position);
}

/* Adds one path from a surface point. */
TY_FN void ty_surfel_add_path(ty_gather* g, const ty_cache_request* request, int32_t surfel,
                              const ty_intersection* start, ty_surfel_sums* sums) {
    ty_path* path = &g->path;
    float single[3] = {0.0f, 0.0f, 0.0f}, multiple[3] = {0.0f, 0.0f, 0.0f}, basis[TY_BAKE_TERMS_MAX];
    const ty_vec ng = start->point.ng, at = start->hit.position;
    ty_path_begin(path, &request->path, (uint64_t)surfel | TY_FOG_ITEM, (uint32_t)sums->paths);
    path->origin = ty_hit_leave(&start->hit, ng);
    path->normal = g->normal = start->point.ns;
    g->inside.top = g->inside.count = 0;
    ty_path_sample_cosine_hemisphere(path);
    ty_gather_basis(g, path->direction, basis);
    const float weight = 1.0f / path->pdf;
    if (ty_dot(ng, path->direction) > 0.0f) ty_cached_radiance(g, false, single, multiple);
    for (int c = 0; c < 3; ++c) {
        const double irradiance = (double)(weight * (single[c] + multiple[c]) * basis[0]);
        sums->square[c] += irradiance * irradiance;
        for (int t = 0; t < TY_SURFEL_TERMS; ++t) {
            sums->light[TY_SURFEL_SINGLE][c][t] += (double)(weight * single[c] * basis[t]);
            sums->light[TY_SURFEL_MULTIPLE][c][t] += (double)(weight * multiple[c] * basis[t]);
        }
    }
    const float position[3] = {at.x, at.y, at.z}, normal[3] = {g->normal.x, g->normal.y, g->normal.z};
    for (int a = 0; a < 3; ++a) {
        sums->position[a] += (double)position[a];
        sums->normal[a] += (double)normal[a];
    }
    if (sums->paths == 0) {
        sums->first = at;
        sums->ng = ng;
    }
    sums->paths += 1;
}

TY_FN void ty_surfel_store(const ty_surfel_sums* sums, float* out) {
    double length = 0;
    if (!(sums->paths > 0)) return;
    for (int a = 0; a < 3; ++a) length += sums->normal[a] * sums->normal[a];
    length = sqrt(length);
    for (int a = 0; a < 3; ++a) {
        out[TY_SURFEL_POSITION + a] = (float)(sums->position[a] / sums->paths);
        out[TY_SURFEL_NORMAL + a] = length > 0 ? (float)(sums->normal[a] / length) : 0.0f;
    }
    float* light = out + TY_SURFEL_IRRADIANCE;
    for (int kind = 0; kind < TY_SURFEL_KINDS; ++kind)
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < TY_SURFEL_TERMS; ++t) *light++ = (float)(sums->light[kind][c][t] / sums->paths);
    for (int c = 0; c < 3; ++c) {
        const double n = sums->paths, sum = sums->light[TY_SURFEL_SINGLE][c][0] + sums->light[TY_SURFEL_MULTIPLE][c][0];
        out[TY_SURFEL_VARIANCE + c] =
            (float)(n > 1 ? fmax(0, (sums->square[c] - sum * sum / n) / (n * (n - 1))) : sums->square[c]);
    }
    out[TY_SURFEL_PATHS] = (float)sums->paths;
}

/* Fills the surfels of a cell. */
TY_FN void ty_surfel_fill(ty_gather* g, const ty_cache_request* request, int32_t cell) {
    const ty_cache_view* view = &request->view;
    const int32_t surfel_axes = view->surfel_axes[cell], count = __builtin_popcount((uint32_t)surfel_axes);
    ty_surfel_sums sums[TY_SURFEL_AXES];
    ty_sampler random = ty_sampler_begin(request->path.sobol, ~request->path.seed, (uint64_t)cell, 0);
    ty_intersection at;
    ty_vec direction;
    memset(sums, 0, sizeof sums);
    for (uint32_t i = 0, full = 0; i < TY_SURFEL_TRIES * request->paths && (int32_t)full < count; ++i) {
        if (!ty_surfel_find(request, cell, &random, &at, &direction)) continue;
        ty_surface_evaluate(&request->path.scene->surfaces[at.hit.surface], &at.hit, direction, &at.point);
        const int32_t axis = ty_surfel_axis(at.point.ng);
        if ((surfel_axes >> axis & 1) == 0 || (uint32_t)sums[axis].paths == request->paths) continue;
        if (sums[axis].paths > 0 && !ty_surfel_is_coplanar(view, sums[axis].first, sums[axis].ng, at.hit.position))
            continue;
        const int32_t surfel =
            view->first_surfel[cell] + __builtin_popcount((uint32_t)surfel_axes & ((1u << axis) - 1u));
        ty_surfel_add_path(g, request, surfel, &at, &sums[axis]);
        full += (uint32_t)sums[axis].paths == request->paths ? 1 : 0;
    }
    for (int32_t axis = 0; axis < TY_SURFEL_AXES; ++axis) {
        float* surfel = ty_surfel_of_cell(view, cell, axis);
        if (surfel != NULL) ty_surfel_store(&sums[axis], surfel);
    }
}

#endif
