/* Which stretches of a ray a light reaches, by its shadow map: the ray's way across the map is followed through a
 * pyramid of least and greatest depths, so that whole blocks of texels are passed at once.
 *
 * Depths are kept as nearness: 1 / depth, or -depth for directional lights. Along a straight line nearness is linear in
 * the place on the map, for all kinds of lights. Texels are taken as far as their surface's farthest corner, by the
 * slope that neighbours show, so that a lit surface does not darken the air before it. */
#ifndef TY_DIRECT_LIT_H
#define TY_DIRECT_LIT_H

#include "base/vector.k.h"
#include "direct/shadow/light_map.h"

enum { TY_LIT_LEVELS = 14, TY_LIT_STRETCHES = 64, TY_LIT_LINES = 16 };

/* Of a block of texels, nearness. */
typedef struct ty_lit_range {
    float least, greatest;
} ty_lit_range;

typedef struct ty_lit_face {
    float to_map[12]; /* a point to x, y in texels and depth, m; lights with a place: x and y times depth */
    float nearest;    /* depth of the nearest texel, m; INFINITY: all are empty */
    float* nodes;     /* all that follows, one after another */
    size_t node_count;
    size_t offset[TY_LIT_LEVELS];        /* of levels there */
    float* texels;                       /* nearness, row by row */
    ty_lit_range* levels[TY_LIT_LEVELS]; /* of blocks of 2^level texels a side; [0]: NULL, that is texels */
} ty_lit_face;

typedef struct ty_lit_map {
    ty_context* context;
    const ty_light_map* map; /* the caller's; outlives this */
    ty_light_view light;
    int32_t levels; /* with level 0; the last is one block */
    ty_lit_face faces[6];
} ty_lit_map;

/* Errors: TY_ERROR_MEMORY. */
ty_result ty_lit_map_create(ty_context* context, const ty_light_view* light, const ty_light_map* map, ty_lit_map** out);
void ty_lit_map_destroy(ty_lit_map* map);

/* Stretches of [from, to] of a ray (unit direction), m, finite, that the light reaches (for spots: within their cone),
 * in order of distance; returns how many, at most TY_LIT_STRETCHES (more are joined: the shortest dark ones between
 * them are taken as lit). What lies outside of a light's map is lit. */
int32_t ty_lit_stretches(const ty_lit_map* map, ty_vec origin, ty_vec direction, float from, float to,
                         float stretches[TY_LIT_STRETCHES][2]);

/* The same for up to TY_LIT_LINES rays from one origin, each with its part [from, to] and its stretches; counts: how
 * many each has. */
typedef struct ty_lit_rays {
    int32_t count;
    ty_vec origin, direction[TY_LIT_LINES];
    float from[TY_LIT_LINES], to[TY_LIT_LINES];
    int32_t counts[TY_LIT_LINES];
    float stretches[TY_LIT_LINES][TY_LIT_STRETCHES][2];
} ty_lit_rays;
void ty_lit_stretches_of(const ty_lit_map* map, ty_lit_rays* rays);

/* The share of the four texels around, weighted by how near they are, that leave a point of a surface with a unit
 * normal lit: they are not nearer to the light than the plane through it by more than `slack` (m). *sure: whether all
 * four say the same, and none is nearer by just less than `close`, where it may be what touches the surface, or the
 * surface itself. */
float ty_lit_share(const ty_lit_map* map, ty_vec point, ty_vec normal, float slack, float close, bool* sure);

#endif
