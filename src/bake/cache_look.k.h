/* Light of cells at points between them. */
#ifndef TY_BAKE_CACHE_LOOK_K_H
#define TY_BAKE_CACHE_LOOK_K_H

#include "bake/cache.h"
#include "scene/phase.k.h"

/* The light that arrives at a point: straight from lights, and all of it. */
typedef struct ty_cache_light {
    float terms[2 * TY_CACHE_TERMS_MAX * TY_CACHE_TERM];
} ty_cache_light;

/* Trilinear between cells' middles, even beyond the outermost. */
TY_FN void ty_cache_look(const ty_cache_view* view, ty_vec at, ty_cache_light* out) {
    const float point[3] = {at.x, at.y, at.z};
    const int32_t count = 2 * TY_CACHE_TERM * view->terms;
    float weight[3];
    const float* light = view->light;
    for (int a = 0; a < 3; ++a) {
        const float x = ty_clampf((point[a] - view->lower[a]) * view->per_metre - 0.5f, 0.0f, (float)(view->size[a] - 1));
        const int32_t low = (int32_t)ty_minf(x, ty_maxf(0.0f, (float)(view->size[a] - 2)));
        weight[a] = x - (float)low;
        light += (size_t)low * view->stride[a];
    }
    for (int32_t i = 0; i < count; ++i) out->terms[i] = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        const float* cell = light;
        float share = 1.0f;
        for (int a = 0; a < 3; ++a) {
            const bool high = (corner >> a & 1) != 0;
            share *= high ? weight[a] : 1.0f - weight[a];
            if (high) cell += view->stride[a];
        }
        for (int32_t i = 0; i < count; ++i) out->terms[i] += share * cell[i];
    }
}

/* Radiance scattered against a ray's direction, per scattering coefficient. Light whose mean direction has length R is
 * taken for a Henyey-Greenstein lobe about it, of that mean cosine: light from one direction alone, even light and all
 * zonal light up to its first harmonic are scattered as they should be, and nothing becomes negative. all: what comes
 * from lights and the rest together. */
TY_FN void ty_cache_scatter(const ty_cache_view* view, const ty_cache_light* light, int32_t all, ty_vec direction,
                            const float g[3], float out[3]) {
    const float* terms = light->terms + all * view->terms * TY_CACHE_TERM;
    for (int c = 0; c < 3; ++c) {
        out[c] = terms[c];
        if (view->terms == 1 || !(out[c] > 0.0f) || g[c] == 0.0f) continue;
        const ty_vec from =
            ty_vec_make(terms[TY_CACHE_TERM + c], terms[2 * TY_CACHE_TERM + c], terms[3 * TY_CACHE_TERM + c]);
        const float length = sqrtf(ty_dot(from, from));
        if (!(length > 1e-6f * out[c])) continue;
        const float mu = ty_clampf(ty_dot(from, direction) / length, -1.0f, 1.0f);
        out[c] *= ty_hg(mu, g[c] * ty_minf(length / out[c], 1.0f)) * (1.0f / TY_INV_4PI);
    }
}

#endif
