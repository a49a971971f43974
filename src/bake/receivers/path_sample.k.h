/* Samples of the baker's reference: paths that media scatter. */
#ifndef TY_BAKE_RECEIVERS_PATH_SAMPLE_K_H
#define TY_BAKE_RECEIVERS_PATH_SAMPLE_K_H

#include "bake/gather/gather.k.h"

/* One path of TY_BAKE_PATH, including scattering by media. */
TY_FN void ty_gather_path(ty_gather* g) {
    ty_path* path = &g->path;
    ty_light_sample sample;
    float basis[TY_BAKE_TERMS_MAX], chosen;
    const float factor[3] = {1.0f, 1.0f, 1.0f};
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const ty_light_view* light = ty_path_choose_light(path, path->origin, &chosen, &sample);
    const float cosine = light != NULL && !probe ? ty_dot(g->normal, sample.wi) : 1.0f;
    if (light != NULL && cosine > 0.0f && (probe || ty_dot(g->face, sample.wi) > 0.0f)) {
        ty_path_add_vertex_light(path, light, chosen, &sample, factor, probe ? TY_INV_4PI : cosine * (1.0f / TY_PI),
                                 0.0f);
        ty_gather_basis(g, sample.wi, basis);
        ty_gather_add_rgb(g, TY_BAKE_DIRECT, path->radiance[TY_PATH_UNCOLLIDED], basis);
        memset(path->radiance, 0, sizeof path->radiance);
    }
    if (!ty_gather_sample_direction(g)) return;
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f / path->pdf;
    ty_gather_basis(g, path->direction, basis);
    g->rays += 2 * ty_path_follow(path);
    for (int32_t path_class = 0; path_class < TY_PATH_CLASS_COUNT; ++path_class)
        ty_gather_add_rgb(g, path_class, path->radiance[path_class], basis);
}

/* Samples [first, first + count) of one receiver by such paths; sum and light are its own. */
TY_FN void ty_gather_path_receiver(TY_GLOBAL const ty_bake_request* request, int64_t item, uint32_t first,
                                   uint32_t count, TY_GLOBAL ty_bake_sums* sum, TY_GLOBAL double* light) {
    ty_gather g = {.request = request};
    if (sum->done != 0) return;
    ty_gather_set_receiver(&g, &request->receivers[item]);
    g.rays = 0;
    g.sums = sum;
    g.light = light;
    for (uint32_t i = first; i < first + count; ++i) {
        for (int c = 0; c < 3; ++c) g.sample[c] = 0.0f;
        ty_path_begin(&g.path, &request->path, (uint64_t)(request->first + item), i);
        g.path.origin = g.origin;
        g.path.normal = g.normal;
        ty_path_begin_inside(&g.path);
        ty_gather_path(&g);
        for (int c = 0; c < 3; ++c) {
            sum->mean[c] += (double)g.sample[c];
            sum->square[c] += (double)g.sample[c] * (double)g.sample[c];
        }
    }
    sum->paths += count;
    sum->rays += g.rays;
    sum->count += (int32_t)count;
}

#endif
