/* Light that arrives in one cell. docs/bake.md explains it. */
#ifndef TY_BAKE_CACHE_FILL_K_H
#define TY_BAKE_CACHE_FILL_K_H

#include "bake/cache.h"
#include "method/path/path.k.h"

/* Sums over paths of a cell. */
typedef struct ty_cache_sums {
    double radiance[TY_CACHE_KINDS][3];
    double toward[TY_CACHE_KINDS][3]; /* of the channels' sum, times the unit vector to where it comes from */
    double paths;
} ty_cache_sums;

TY_FN void ty_cache_add(ty_cache_sums* sums, int32_t kind, const float radiance[3], ty_vec from) {
    const float all = ty_sum3(radiance);
    double* toward = sums->toward[kind];
    for (int c = 0; c < 3; ++c) sums->radiance[kind][c] += (double)radiance[c];
    toward[0] += (double)(all * from.x);
    toward[1] += (double)(all * from.y);
    toward[2] += (double)(all * from.z);
}

TY_FN double ty_cache_sum(const ty_cache_sums* sums, int32_t kind) {
    return sums->radiance[kind][0] + sums->radiance[kind][1] + sums->radiance[kind][2];
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

/* One path from where light is to be scattered, which is the first scattering of its run. sums: of paths whose first
 * ray meets no back of a surface, and of those where it does. Returns rays. */
TY_FN uint64_t ty_cache_sample(const ty_cache_request* request, int32_t cell, uint32_t number, ty_cache_sums sums[2]) {
    const float factor[3] = {TY_INV_4PI, TY_INV_4PI, TY_INV_4PI};
    const ty_mesh* mesh = request->path.scene->mesh;
    ty_path path;
    ty_light_sample sample;
    ty_hit hit;
    float chosen, straight[3], rest[3];
    ty_path_begin(&path, &request->path, (uint64_t)cell, number);
    path.origin = ty_cache_point(&request->view, cell, &path.random);
    path.run = 1;
    const ty_light_view* light = ty_path_choose_light(&path, path.origin, &chosen, &sample);
    if (light != NULL) ty_path_add_vertex_light(&path, light, chosen, &sample, factor, TY_INV_4PI, 0.0f);
    memcpy(straight, path.radiance[TY_PART_UNCOLLIDED], sizeof straight);
    memset(path.radiance, 0, sizeof path.radiance);
    ty_path_turn_anywhere(&path);
    const ty_vec direction = path.direction;
    const bool back = mesh != NULL && ty_mesh_intersect(mesh, path.origin, direction, TY_FLOAT_MAX, &hit) &&
                      ty_dot(hit.normal, direction) > 0.0f;
    const uint64_t rays = 3 + 2 * ty_path_follow(&path);
    ty_cache_sums* sum = &sums[back ? 1 : 0];
    for (int c = 0; c < 3; ++c)
        rest[c] =
            path.radiance[TY_PART_REFLECTED][c] + path.radiance[TY_PART_SINGLE][c] + path.radiance[TY_PART_MULTIPLE][c];
    if (light != NULL) ty_cache_add(sum, TY_CACHE_ONCE, straight, sample.look);
    ty_cache_add(sum, TY_CACHE_ONCE, path.radiance[TY_PART_UNCOLLIDED], direction);
    ty_cache_add(sum, TY_CACHE_REST, rest, direction);
    sum->paths += 1;
    return rays;
}

/* What a cell keeps of one kind of light. */
TY_FN void ty_cache_keep(const ty_cache_view* view, const ty_cache_sums* sums, int32_t kind, float* out) {
    const double all = ty_cache_sum(sums, kind);
    const double* toward = sums->toward[kind];
    const double length = sqrt(toward[0] * toward[0] + toward[1] * toward[1] + toward[2] * toward[2]);
    for (int c = 0; c < 3; ++c) out[c] = (float)(sums->radiance[kind][c] / sums->paths);
    if (view->floats < 8 || !(length > 0)) return;
    out[3] = (float)(length < all ? length / all : 1);
    for (int a = 0; a < 3; ++a) out[4 + a] = (float)(toward[a] / length);
}

/* Where rays meet backs of surfaces and no light at all, they begin within walls: of cells that are partly there, the
 * rest alone counts. False: nothing does. */
TY_FN bool ty_cache_fill(const ty_cache_request* request, int32_t cell, float* light, uint64_t* rays) {
    ty_cache_sums sums[2];
    memset(sums, 0, sizeof sums);
    for (uint32_t i = 0; i < request->paths; ++i) *rays += ty_cache_sample(request, cell, i, sums);
    if (ty_cache_sum(&sums[1], TY_CACHE_ONCE) + ty_cache_sum(&sums[1], TY_CACHE_REST) > 0) {
        sums[0].paths += sums[1].paths;
        for (int32_t k = 0; k < TY_CACHE_KINDS; ++k)
            for (int a = 0; a < 3; ++a) {
                sums[0].radiance[k][a] += sums[1].radiance[k][a];
                sums[0].toward[k][a] += sums[1].toward[k][a];
            }
    }
    if (!(sums[0].paths > 0)) return false;
    for (int32_t k = 0; k < TY_CACHE_KINDS; ++k)
        ty_cache_keep(&request->view, &sums[0], k, light + k * request->view.floats);
    return true;
}

#endif
