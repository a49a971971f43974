/* Light that arrives in one cell. docs/bake.md explains it. */
#ifndef TY_BAKE_CACHE_FILL_K_H
#define TY_BAKE_CACHE_FILL_K_H

#include "bake/cache.h"
#include "method/path/path.k.h"

/* Sums over a cell's paths, as the cell keeps them: light straight from lights, and the rest. */
typedef struct ty_cache_sums {
    double terms[2][TY_CACHE_TERMS_MAX][3];
} ty_cache_sums;

TY_FN void ty_cache_add(ty_cache_sums* sums, int32_t rest, const float radiance[3], ty_vec from) {
    const float factor[TY_CACHE_TERMS_MAX] = {1.0f, from.x, from.y, from.z};
    for (int32_t t = 0; t < TY_CACHE_TERMS_MAX; ++t)
        for (int c = 0; c < 3; ++c) sums->terms[rest][t][c] += (double)(factor[t] * radiance[c]);
}

/* Somewhere in the cell. */
TY_FN ty_vec ty_cache_point(const ty_cache_view* view, int32_t cell, ty_random* random) {
    const int32_t index[3] = {cell % view->size[0], cell / view->size[0] % view->size[1],
                              cell / (view->size[0] * view->size[1])};
    float point[3];
    for (int a = 0; a < 3; ++a)
        point[a] = view->lower[a] + ((float)index[a] + ty_random_next(random)) / view->per_metre;
    return ty_vec_load(point);
}

/* One path from where light is to be scattered, which is the first scattering of its run. Returns rays. */
TY_FN uint64_t ty_cache_sample(const ty_cache_request* request, int32_t cell, uint32_t number, ty_cache_sums* sums) {
    const float factor[3] = {TY_INV_4PI, TY_INV_4PI, TY_INV_4PI};
    ty_path path;
    ty_light_sample sample;
    float chosen, rest[3];
    ty_path_begin(&path, &request->path, (uint64_t)cell, number);
    path.origin = ty_cache_point(&request->view, cell, &path.random);
    path.run = 1;
    const ty_light_view* light = ty_path_choose_light(&path, path.origin, &chosen, &sample);
    if (light != NULL) {
        ty_path_add_vertex_light(&path, light, chosen, &sample, factor, TY_INV_4PI, 0.0f);
        ty_cache_add(sums, 0, path.radiance[TY_PART_UNCOLLIDED], sample.look);
        memset(path.radiance, 0, sizeof path.radiance);
    }
    ty_path_turn_anywhere(&path);
    const ty_vec direction = path.direction;
    const uint64_t rays = 2 + 2 * ty_path_follow(&path);
    ty_cache_add(sums, 0, path.radiance[TY_PART_UNCOLLIDED], direction);
    for (int c = 0; c < 3; ++c)
        rest[c] = path.radiance[TY_PART_REFLECTED][c] + path.radiance[TY_PART_SINGLE][c] +
                  path.radiance[TY_PART_MULTIPLE][c];
    ty_cache_add(sums, 1, rest, direction);
    return rays;
}

TY_FN uint64_t ty_cache_fill(const ty_cache_request* request, int32_t cell, float* light) {
    const int32_t terms = request->view.terms;
    ty_cache_sums sums;
    uint64_t rays = 0;
    memset(&sums, 0, sizeof sums);
    for (uint32_t i = 0; i < request->paths; ++i) rays += ty_cache_sample(request, cell, i, &sums);
    for (int32_t t = 0; t < terms; ++t)
        for (int c = 0; c < 3; ++c) {
            const double straight = sums.terms[0][t][c] / request->paths;
            light[t * TY_CACHE_TERM + c] = (float)straight;
            light[(terms + t) * TY_CACHE_TERM + c] = (float)(straight + sums.terms[1][t][c] / request->paths);
        }
    return rays;
}

#endif
