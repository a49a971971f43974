/* Light of cells at points between them. */
#ifndef TY_BAKE_CACHE_LOOK_K_H
#define TY_BAKE_CACHE_LOOK_K_H

#include "bake/cache.h"
#include "scene/phase.k.h"

/* The light of one of the eight cells around a point, by a chance that makes the mean trilinear between cells' middles,
 * even beyond the outermost. */
TY_FN const float* ty_cache_look(const ty_cache_view* view, ty_vec at, ty_random* random) {
    const uint64_t bits = ty_random_bits(random);
    const float jitter[3] = {(float)(uint32_t)(bits >> 43) * 0x1p-21f,
                             (float)(uint32_t)(bits >> 22 & 0x1fffffu) * 0x1p-21f,
                             (float)(uint32_t)(bits & 0x1fffffu) * 0x1p-21f};
    const float point[3] = {at.x, at.y, at.z};
    int32_t cell = 0;
    for (int a = 2; a >= 0; --a) {
        const float x = (point[a] - view->lower[a]) * view->per_metre + jitter[a] - 0.5f;
        cell = cell * view->size[a] + (int32_t)ty_clampf(x, 0.0f, (float)(view->size[a] - 1));
    }
    return view->light + (size_t)cell * (size_t)(TY_CACHE_KINDS * view->floats);
}

/* Radiance scattered against a ray's direction, per scattering coefficient, of one kind of light. Light whose mean
 * direction has length R is taken for a Henyey-Greenstein lobe about it, of that mean cosine: light from one direction
 * alone, even light and all zonal light up to its first harmonic are scattered as they should be, and nothing becomes
 * negative. gray: g is alike in all channels. */
TY_FN void ty_cache_scatter(const float* part, ty_vec direction, const float g[3], int32_t gray, float out[3]) {
    const float mu = ty_clampf(ty_dot(ty_vec_load(part + 4), direction), -1.0f, 1.0f), lobe = part[3];
    const float first = ty_hg(mu, g[0] * lobe) * (1.0f / TY_INV_4PI);
    out[0] = part[0] * first;
    out[1] = part[1] * (gray != 0 ? first : ty_hg(mu, g[1] * lobe) * (1.0f / TY_INV_4PI));
    out[2] = part[2] * (gray != 0 ? first : ty_hg(mu, g[2] * lobe) * (1.0f / TY_INV_4PI));
}

#endif
