/* Irradiance of surfaces on a hashed grid, for kernels. */
#ifndef TY_IMAGE_IRRADIANCE_CACHE_K_H
#define TY_IMAGE_IRRADIANCE_CACHE_K_H

#include "base/vector.k.h"

#define TY_IRRADIANCE_EMPTY 0xffffffffu
/* Of cells beside the media's box, relative to its longest side: edge, and distance from which it doubles, then doubles
 * again. */
#define TY_IRRADIANCE_EDGE 0.2f
#define TY_IRRADIANCE_REACH 0.5f
enum { TY_IRRADIANCE_LEVELS = 16 };

/* Points of surfaces, one for each cell and each of six directions that the surface faces. */
typedef struct ty_irradiance_view {
    int32_t count;            /* points; 0: no cache */
    int32_t bits;             /* the table has 2^bits entries */
    ty_vec center, half_side; /* of the media's box, m */
    float longest;            /* its longest side, m */
    TY_GLOBAL const uint32_t* keys;
    TY_GLOBAL const int32_t* points;   /* of the entries */
    TY_GLOBAL const float* irradiance; /* of light that media have scattered: 3 for each point, W m^-2 */
} ty_irradiance_view;

/* Place of a coordinate in cells, 0..255. */
TY_FN uint32_t ty_irradiance_place(float offset, float per_edge) {
    const float place = floorf(offset * per_edge + 128.37f);
    return (uint32_t)ty_clampf(place, 0.0f, 255.0f);
}

/* Edge of the cells at a point relative to the box's center, m, and how many times it was doubled. */
TY_FN float ty_irradiance_edge(const ty_irradiance_view* view, ty_vec off, uint32_t* level) {
    const ty_vec out =
        ty_vec_make(ty_maxf(0.0f, fabsf(off.x) - view->half_side.x), ty_maxf(0.0f, fabsf(off.y) - view->half_side.y),
                    ty_maxf(0.0f, fabsf(off.z) - view->half_side.z));
    const float distance = sqrtf(ty_dot(out, out));
    float reach = TY_IRRADIANCE_REACH * view->longest, edge = TY_IRRADIANCE_EDGE * view->longest;
    *level = 0;
    for (; distance > reach && *level + 1 < TY_IRRADIANCE_LEVELS; ++*level) {
        reach *= 2.0f;
        edge *= 2.0f;
    }
    return edge;
}

/* The cell of a point on a surface that faces `normal`. */
TY_FN uint32_t ty_irradiance_key(const ty_irradiance_view* view, ty_vec point, ty_vec normal) {
    const ty_vec off = ty_sub(point, view->center);
    uint32_t level;
    const float per_edge = 1.0f / ty_irradiance_edge(view, off, &level);
    const float x = fabsf(normal.x), y = fabsf(normal.y), z = fabsf(normal.z);
    const uint32_t face = x >= y && x >= z ? (normal.x < 0.0f ? 0 : 1)
                          : y >= z         ? (normal.y < 0.0f ? 2 : 3)
                                           : (normal.z < 0.0f ? 4 : 5);
    return level << 27 | face << 24 | ty_irradiance_place(off.x, per_edge) << 16 |
           ty_irradiance_place(off.y, per_edge) << 8 | ty_irradiance_place(off.z, per_edge);
}

/* The entry of a key: its own, or the empty one where it would be. */
TY_FN uint32_t ty_irradiance_entry(const ty_irradiance_view* view, uint32_t key) {
    const uint32_t mask = (1u << view->bits) - 1u;
    uint32_t entry = (key * 2654435769u) >> (32 - view->bits);
    while (view->keys[entry] != TY_IRRADIANCE_EMPTY && view->keys[entry] != key) entry = (entry + 1u) & mask;
    return entry;
}

/* The point for a place on a surface: that of its cell, or of one beside it; -1: there is none. */
TY_FN int32_t ty_irradiance_find(const ty_irradiance_view* view, ty_vec point, ty_vec normal) {
    uint32_t level;
    const float aside = 0.5f * ty_irradiance_edge(view, ty_sub(point, view->center), &level);
    for (int32_t i = 0; i < 7; ++i) {
        const float by = i == 0 ? 0.0f : (i & 1) != 0 ? aside : -aside;
        const ty_vec at = ty_add(point, ty_vec_make((i + 1) / 2 == 1 ? by : 0.0f, (i + 1) / 2 == 2 ? by : 0.0f,
                                                    (i + 1) / 2 == 3 ? by : 0.0f));
        const uint32_t key = ty_irradiance_key(view, at, normal), entry = ty_irradiance_entry(view, key);
        if (view->keys[entry] == key) return view->points[entry];
    }
    return -1;
}

#endif
