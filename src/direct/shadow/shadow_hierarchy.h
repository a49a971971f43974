/* Which stretches of a ray a light reaches, by its shadow map: the ray's way across the map is followed through a
 * pyramid of least and greatest depths, so that whole blocks of texels are passed at once.
 *
 * Depths are kept as nearness: 1 / depth, or -depth for directional lights. Along a straight line nearness is linear in
 * the place on the map, for all kinds of lights. Texels are taken as far as their surface's farthest corner, by the
 * slope that neighbours show, so that a lit surface does not darken the air before it. */
#ifndef TY_DIRECT_SHADOW_HIERARCHY_H
#define TY_DIRECT_SHADOW_HIERARCHY_H

#include "base/vector.k.h"
#include "direct/shadow/rsm.h"

enum { TY_SHADOW_LEVELS_MAX = 14, TY_LIT_SEGMENTS_MAX = 64, TY_SHADOW_RAYS_MAX = 16 };

/* Of a block of texels, nearness. */
typedef struct ty_shadow_range {
    float least, greatest;
} ty_shadow_range;

typedef struct ty_shadow_face {
    float to_map[12]; /* a point to x, y in texels and depth, m; lights with a place: x and y times depth */
    float nearest;    /* depth of the nearest texel, m; INFINITY: all are empty */
    float* nodes;     /* all that follows, one after another */
    size_t node_count;
    size_t offset[TY_SHADOW_LEVELS_MAX];           /* of levels there */
    float* texels;                                 /* nearness, row by row */
    ty_shadow_range* levels[TY_SHADOW_LEVELS_MAX]; /* of blocks of 2^level texels a side; [0]: NULL, that is texels */
} ty_shadow_face;

typedef struct ty_shadow_hierarchy {
    ty_context* context;
    const ty_rsm* map; /* the caller's; outlives this */
    ty_light_view light;
    int32_t levels; /* with level 0; the last is one block */
    ty_shadow_face faces[6];
} ty_shadow_hierarchy;

/* Errors: TY_ERROR_MEMORY. */
ty_result ty_shadow_hierarchy_create(ty_context* context, const ty_light_view* light, const ty_rsm* map,
                                     ty_shadow_hierarchy** out);
void ty_shadow_hierarchy_destroy(ty_shadow_hierarchy* map);

/* Stretches of [from, to] of a ray (unit direction), m, finite, that the light reaches (for spots: within their cone),
 * in order of distance; returns how many, at most TY_LIT_SEGMENTS_MAX (more are joined: the shortest dark ones between
 * them are taken as lit). What lies outside of a light's map is lit. */
int32_t ty_shadow_lit_segments(const ty_shadow_hierarchy* map, ty_vec origin, ty_vec direction, float from, float to,
                               float segments[TY_LIT_SEGMENTS_MAX][2]);

/* The same for up to TY_SHADOW_RAYS_MAX rays from one origin, each with its part [from, to] and its stretches; counts:
 * how many each has. */
typedef struct ty_shadow_rays {
    int32_t count;
    ty_vec origin, direction[TY_SHADOW_RAYS_MAX];
    float from[TY_SHADOW_RAYS_MAX], to[TY_SHADOW_RAYS_MAX];
    int32_t counts[TY_SHADOW_RAYS_MAX];
    float segments[TY_SHADOW_RAYS_MAX][TY_LIT_SEGMENTS_MAX][2];
} ty_shadow_rays;
void ty_shadow_lit_segments_of(const ty_shadow_hierarchy* map, ty_shadow_rays* rays);

/* The share of the four texels around, weighted by how near they are, that leave a point of a surface with a unit
 * normal lit: they are not nearer to the light than the plane through it by more than `slack` (m). *sure: whether all
 * four say the same, and none is nearer by just less than `close`, where it may be what touches the surface, or the
 * surface itself. */
float ty_shadow_visibility(const ty_shadow_hierarchy* map, ty_vec point, ty_vec normal, float slack, float close,
                           bool* sure);

#endif
