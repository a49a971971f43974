/* Which stretches of a ray a light reaches, by its shadow map: the ray's way across the map is followed through a
 * pyramid of least and greatest depths, so that whole blocks of texels are passed at once. */
#ifndef TY_DIRECT_LIT_H
#define TY_DIRECT_LIT_H

#include "base/vector.k.h"
#include "direct/light_map.h"

enum { TY_LIT_LEVELS = 14, TY_LIT_STRETCHES = 64 };

typedef struct ty_lit_map {
    ty_context* context;
    const ty_light_map* map; /* the caller's; outlives this */
    ty_light_view light;
    int32_t levels;
    float* least[6][TY_LIT_LEVELS]; /* per face and level, side halved (rounded up) from level to level; [0]: depth */
    float* greatest[6][TY_LIT_LEVELS];
} ty_lit_map;

/* Errors: TY_ERROR_MEMORY. */
ty_result ty_lit_map_create(ty_context* context, const ty_light_view* light, const ty_light_map* map, ty_lit_map** out);
void ty_lit_map_destroy(ty_lit_map* map);

/* Stretches of [from, to] of a ray (unit direction), m, that the light reaches (for spots: within their cone), in order
 * of distance; returns how many, at most TY_LIT_STRETCHES (more are joined: the shortest dark ones between them are
 * taken as lit). What lies outside of a directional light's map is lit. */
int32_t ty_lit_stretches(const ty_lit_map* map, ty_vec origin, ty_vec direction, float from, float to,
                         float stretches[TY_LIT_STRETCHES][2]);

/* Whether the light reaches a point: 1, 0, or -1 where texels around differ, or lie within `slack` (m) of the
 * point's depth. */
int32_t ty_lit_at(const ty_lit_map* map, ty_vec point, float slack);

#endif
