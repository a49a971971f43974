/* Light that media scattered, on the surfaces in cells: walks over surfaces, through media whose light is known.
 * docs/bake.md explains it. */
#ifndef TY_BAKE_CACHE_WALLS_K_H
#define TY_BAKE_CACHE_WALLS_K_H

#include "bake/cache_fill.k.h"
#include "bake/cached.k.h"

/* Random rays within a cell that look for its surfaces, per walk that each wall should have. */
enum { TY_WALL_TRIES = 16 };

typedef struct ty_wall_sums {
    double light[TY_WALL_KINDS][3][TY_WALL_TERMS];
    double square[3]; /* of irradiance */
    double place[3], normal[3], walks;
    ty_vec first, facing; /* the first point's place and normal */
} ty_wall_sums;

/* A point on a surface in a cell, found from a random one; false where there is none. */
TY_FN bool ty_wall_find(const ty_cache_request* request, int32_t cell, ty_sampler* random, ty_intersection* out,
                        ty_vec* direction) {
    const ty_cache_view* view = &request->view;
    const ty_scene_view* scene = request->path.scene;
    const float x = ty_rng_uniform(random), y = ty_rng_uniform(random), z = ty_rng_uniform(random);
    const float u = ty_rng_uniform(random), v = ty_rng_uniform(random);
    const ty_vec from = ty_cache_point(view, cell, x, y, z);
    *direction = ty_direction_about(ty_vec_make(0, 0, 1), 1.0f - 2.0f * u, v);
    const float far = 1.7320508f / view->per_metre;
    return ty_accel_intersect(scene->mesh, from, *direction, far, &out->hit) &&
           ty_cache_cell(view, out->hit.position) == cell && ty_cache_holds(view, out->hit.position);
}

/* One walk from a point on a surface. */
TY_FN void ty_wall_walk(ty_gather* g, const ty_cache_request* request, int32_t wall, const ty_intersection* start,
                        ty_wall_sums* sums) {
    ty_path* path = &g->path;
    float single[3] = {0.0f, 0.0f, 0.0f}, multiple[3] = {0.0f, 0.0f, 0.0f}, basis[TY_BAKE_TERMS_MAX];
    const ty_vec facing = start->point.ng, at = start->hit.position;
    ty_path_begin(path, &request->path, (uint64_t)wall | TY_FOG_ITEM, (uint32_t)sums->walks);
    path->origin = ty_hit_leave(&start->hit, facing);
    path->normal = g->normal = start->point.ns;
    ty_path_sample_cosine_hemisphere(path);
    ty_gather_basis(g, path->direction, basis);
    const float weight = 1.0f / path->pdf;
    if (ty_dot(facing, path->direction) > 0.0f) ty_cached_walk(g, false, single, multiple);
    for (int c = 0; c < 3; ++c) {
        const double irradiance = (double)(weight * (single[c] + multiple[c]) * basis[0]);
        sums->square[c] += irradiance * irradiance;
        for (int t = 0; t < TY_WALL_TERMS; ++t) {
            sums->light[TY_WALL_SINGLE][c][t] += (double)(weight * single[c] * basis[t]);
            sums->light[TY_WALL_MULTIPLE][c][t] += (double)(weight * multiple[c] * basis[t]);
        }
    }
    const float place[3] = {at.x, at.y, at.z}, normal[3] = {g->normal.x, g->normal.y, g->normal.z};
    for (int a = 0; a < 3; ++a) {
        sums->place[a] += (double)place[a];
        sums->normal[a] += (double)normal[a];
    }
    if (sums->walks == 0) {
        sums->first = at;
        sums->facing = facing;
    }
    sums->walks += 1;
}

TY_FN void ty_wall_keep(const ty_wall_sums* sums, float* out) {
    double length = 0;
    if (!(sums->walks > 0)) return;
    for (int a = 0; a < 3; ++a) length += sums->normal[a] * sums->normal[a];
    length = sqrt(length);
    for (int a = 0; a < 3; ++a) {
        out[TY_WALL_PLACE + a] = (float)(sums->place[a] / sums->walks);
        out[TY_WALL_NORMAL + a] = length > 0 ? (float)(sums->normal[a] / length) : 0.0f;
    }
    float* light = out + TY_WALL_LIGHT;
    for (int kind = 0; kind < TY_WALL_KINDS; ++kind)
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < TY_WALL_TERMS; ++t) *light++ = (float)(sums->light[kind][c][t] / sums->walks);
    for (int c = 0; c < 3; ++c) {
        const double n = sums->walks, sum = sums->light[TY_WALL_SINGLE][c][0] + sums->light[TY_WALL_MULTIPLE][c][0];
        out[TY_WALL_VARIANCE + c] =
            (float)(n > 1 ? fmax(0, (sums->square[c] - sum * sum / n) / (n * (n - 1))) : sums->square[c]);
    }
    out[TY_WALL_WALKS] = (float)sums->walks;
}

/* Fills the walls of a cell. */
TY_FN void ty_wall_fill(ty_gather* g, const ty_cache_request* request, int32_t cell) {
    const ty_cache_view* view = &request->view;
    const int32_t ways = view->ways[cell], count = __builtin_popcount((uint32_t)ways);
    ty_wall_sums sums[TY_WALL_WAYS];
    ty_sampler random = ty_sampler_begin(request->path.sobol, ~request->path.seed, (uint64_t)cell, 0);
    ty_intersection at;
    ty_vec direction;
    memset(sums, 0, sizeof sums);
    for (uint32_t i = 0, full = 0; i < TY_WALL_TRIES * request->paths && (int32_t)full < count; ++i) {
        if (!ty_wall_find(request, cell, &random, &at, &direction)) continue;
        ty_surface_evaluate(&request->path.scene->surfaces[at.hit.surface], &at.hit, direction, &at.point);
        const int32_t way = ty_wall_way(at.point.ng);
        if ((ways >> way & 1) == 0 || (uint32_t)sums[way].walks == request->paths) continue;
        if (sums[way].walks > 0 && !ty_wall_is_flush(view, sums[way].first, sums[way].facing, at.hit.position))
            continue;
        const int32_t wall = view->first[cell] + __builtin_popcount((uint32_t)ways & ((1u << way) - 1u));
        ty_wall_walk(g, request, wall, &at, &sums[way]);
        full += (uint32_t)sums[way].walks == request->paths ? 1 : 0;
    }
    for (int32_t way = 0; way < TY_WALL_WAYS; ++way) {
        float* wall = ty_wall_of(view, cell, way);
        if (wall != NULL) ty_wall_keep(&sums[way], wall);
    }
}

#endif
