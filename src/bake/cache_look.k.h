/* Light of cells at points between them. */
#ifndef TY_BAKE_CACHE_LOOK_K_H
#define TY_BAKE_CACHE_LOOK_K_H

#include "bake/cache.h"
#include "scene/phase.k.h"

TY_FN int32_t ty_cache_cell(const ty_cache_view* view, ty_vec at) {
    const int32_t* size = view->size;
    const float m = view->per_metre;
    const int32_t x = (int32_t)ty_clampf((at.x - view->lower[0]) * m, 0.0f, (float)(size[0] - 1));
    const int32_t y = (int32_t)ty_clampf((at.y - view->lower[1]) * m, 0.0f, (float)(size[1] - 1));
    const int32_t z = (int32_t)ty_clampf((at.z - view->lower[2]) * m, 0.0f, (float)(size[2] - 1));
    return x + size[0] * (y + size[1] * z);
}

TY_FN bool ty_cache_sees(const ty_mesh* mesh, ty_vec from, ty_vec to) {
    const ty_vec way = ty_sub(to, from);
    const float distance = sqrtf(ty_dot(way, way));
    return !(distance > 0.0f) || !ty_mesh_occluded(mesh, from, ty_scale(way, 1.0f / distance), distance);
}

/* The light of the side of a cell that a point sees; NULL: it sees neither. */
TY_FN const float* ty_cache_side(const ty_cache_view* view, const ty_mesh* mesh, int32_t cell, ty_vec at) {
    const size_t place = (size_t)cell * (size_t)(TY_CACHE_KINDS * view->floats);
    const float* anchor = view->anchor + (size_t)cell * (3 * TY_CACHE_SIDES);
    const uint8_t known = view->known[cell];
    if ((known & 1) != 0 && ty_cache_sees(mesh, at, ty_vec_load(anchor))) return view->light + place;
    if ((known & 2) != 0 && ty_cache_sees(mesh, at, ty_vec_load(anchor + 3))) return view->other + place;
    return NULL;
}

/* The light of one of the eight cells around a point, by a chance that makes the mean trilinear between cells' middles,
 * even beyond the outermost. Near surfaces that cut cells, or cells from each other, light counts that the point sees
 * where it was gathered. */
TY_FN const float* ty_cache_look(const ty_cache_view* view, const ty_mesh* mesh, ty_vec at, ty_random* random) {
    const uint64_t bits = ty_random_bits(random);
    const float half = 0.5f, metres = 1.0f / view->per_metre;
    const ty_vec jitter = ty_vec_make((float)(uint32_t)(bits >> 43) * 0x1p-21f - half,
                                      (float)(uint32_t)(bits >> 22 & 0x1fffffu) * 0x1p-21f - half,
                                      (float)(uint32_t)(bits & 0x1fffffu) * 0x1p-21f - half);
    const int32_t cell = ty_cache_cell(view, ty_mad(at, jitter, metres)), own = ty_cache_cell(view, at);
    const size_t each = (size_t)(TY_CACHE_KINDS * view->floats);
    const bool single = (view->known[own] & ~TY_CACHE_CUT) == 1; /* side: there is no other to be on */
    if ((view->known[own] & TY_CACHE_CUT) == 0 || (cell == own && single)) return view->light + (size_t)cell * each;
    const float* light = ty_cache_side(view, mesh, cell, at);
    if (light == NULL && cell != own && !single) light = ty_cache_side(view, mesh, own, at);
    return light != NULL ? light : view->light + (size_t)own * each;
}

/* Radiance scattered against a ray's direction, per scattering coefficient, of one kind of light. Light whose mean
 * direction has length R is taken for a Henyey-Greenstein lobe about it, of that mean cosine: light from one direction
 * alone, even light and all zonal light up to its first harmonic are scattered as they should be, and nothing becomes
 * negative. */
TY_FN void ty_cache_scatter(const ty_cache_view* view, const float* light, ty_vec direction, const float g[3],
                            float out[3]) {
    for (int c = 0; c < 3; ++c) out[c] = light[c];
    if (view->floats == TY_CACHE_EVEN) return;
    const float mu = ty_clampf(ty_dot(ty_vec_load(light + 3), direction), -1.0f, 1.0f);
    float lobe = ty_hg(mu, g[0] * light[6]) * (1.0f / TY_INV_4PI);
    for (int c = 0; c < 3; ++c) {
        if (c > 0 && view->floats == TY_CACHE_COLORED) lobe = ty_hg(mu, g[c] * light[6 + c]) * (1.0f / TY_INV_4PI);
        out[c] *= lobe;
    }
}

#endif
