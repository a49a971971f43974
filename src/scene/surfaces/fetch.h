/* Prefetching of surface attributes at hits, which are scattered in memory: the latency is paid once per packet, not
 * per hit. */
#ifndef TY_SCENE_SURFACES_FETCH_H
#define TY_SCENE_SURFACES_FETCH_H

#include "scene/surfaces/surface.k.h"

static inline void ty_fetch_corners(const ty_surface* surface, int32_t triangle) {
    const uint32_t* corners = surface->indices + 3 * (size_t)triangle;
    const float* uv = ty_texture_exists(&surface->albedo_texture) ? surface->uv[surface->albedo_uv] : NULL;
    for (int i = 0; i < 3; ++i) {
        if (uv != NULL) __builtin_prefetch(uv + 2 * (size_t)corners[i]);
        if (surface->normals != NULL) __builtin_prefetch(surface->normals + 3 * (size_t)corners[i]);
    }
}

/* After ty_fetch_corners. Approximate texel positions suffice. */
static inline void ty_fetch_texels(const ty_surface* surface, const ty_hit* hit) {
    const ty_texture_view* texture = &surface->albedo_texture;
    const float *set = surface->uv[surface->albedo_uv], *map = surface->albedo_map;
    float uv[2];
    if (texture->rgba8 == NULL || set == NULL) return;
    ty_surface_interpolate(set, 2, surface->indices + 3 * (size_t)hit->primitive_id, hit->b1, hit->b2, uv);
    const float u = map[0] * uv[0] + map[1] * uv[1] + map[2], v = map[3] * uv[0] + map[4] * uv[1] + map[5];
    const float x = ty_texture_coordinate(u, texture->wrap[0]) * (float)texture->width - 0.5f;
    const float y = ty_texture_coordinate(v, texture->wrap[1]) * (float)texture->height - 0.5f;
    const int32_t column = ty_texture_wrap((int32_t)x, texture->width, texture->wrap[0]);
    for (int32_t j = 0; j < 2; ++j) {
        const int32_t line = ty_texture_wrap((int32_t)y + j, texture->height, texture->wrap[1]);
        const uint8_t* texel = texture->rgba8 + 4 * ((size_t)column + (size_t)texture->width * (size_t)line);
        __builtin_prefetch(texel);
        __builtin_prefetch(texel + 4);
    }
}

/* Prefetches the data that ty_surface_evaluate reads for each hit; surface -1 is skipped. */
static inline void ty_surfaces_fetch(const ty_surface* surfaces, const ty_hit* hits, int32_t count) {
    for (int32_t i = 0; i < count; ++i)
        if (hits[i].surface >= 0 && surfaces[hits[i].surface].indices != NULL)
            ty_fetch_corners(&surfaces[hits[i].surface], hits[i].primitive_id);
    for (int32_t i = 0; i < count; ++i)
        if (hits[i].surface >= 0 && surfaces[hits[i].surface].indices != NULL)
            ty_fetch_texels(&surfaces[hits[i].surface], &hits[i]);
}

/* ty_surface_evaluate, inlined whole for Lambertian surfaces. */
__attribute__((flatten)) static inline void ty_surface_evaluate_fetched(const ty_surface* surface, const ty_hit* hit,
                                                                        ty_vec direction, ty_surface_point* out) {
    if (surface->gloss != NULL) {
        ty_surface_evaluate(surface, hit, direction, out);
        return;
    }
    ty_surface_point_look(surface, hit, direction, out);
    out->glossy = 0;
}

#endif
