/* A min-max hierarchy over a shadow map (Chen, Baran, Durand, Jarosz 2011), which finds the lit segments of a ray: the
 * ray is traversed across the map, and blocks of texels that are wholly in front of or behind it are passed at once.
 *
 * Depths are stored as inverse depth, 1 / depth, or -depth for directional lights: along a straight line it is linear
 * in the position on the map for every kind of light. A texel's depth is biased to the farthest corner of its surface
 * by the slope of its neighbours, so that a lit surface casts no shadow on the medium in front of it. */
#ifndef TY_DIRECT_SHADOW_SHADOW_HIERARCHY_H
#define TY_DIRECT_SHADOW_SHADOW_HIERARCHY_H

#include "base/vector.k.h"
#include "direct/shadow/rsm.h"

enum { TY_SHADOW_LEVELS_MAX = 14, TY_LIT_SEGMENTS_MAX = 64, TY_SHADOW_RAYS_MAX = 16 };

/* The inverse depths of a block of texels. */
typedef struct ty_shadow_range {
    float min, max;
} ty_shadow_range;

typedef struct ty_shadow_face {
    float to_map[12]; /* affine map from a point to x, y (texels; times depth for local lights) and depth, m */
    float nearest;    /* smallest depth of all texels, m; INFINITY: all texels are empty */
    float* nodes;     /* memory of the texels and levels below */
    size_t node_count;
    size_t offset[TY_SHADOW_LEVELS_MAX]; /* of each level in nodes */
    float* texels;                       /* inverse depth, row by row */
    ty_shadow_range*
        levels[TY_SHADOW_LEVELS_MAX]; /* ranges of blocks of 2^level texels a side; [0] is NULL: see texels */
} ty_shadow_face;

typedef struct ty_shadow_hierarchy {
    ty_context* context;
    const ty_rsm* map; /* owned by the caller, must outlive this */
    ty_light_view light;
    int32_t levels; /* including level 0; the last level is one block */
    ty_shadow_face faces[6];
} ty_shadow_hierarchy;

/* Errors: TY_ERROR_MEMORY. */
ty_result ty_shadow_hierarchy_create(ty_context* context, const ty_light_view* light, const ty_rsm* map,
                                     ty_shadow_hierarchy** out);
void ty_shadow_hierarchy_destroy(ty_shadow_hierarchy* map);

/* The segments of a ray's finite interval [from, to], m, that the light reaches (for spot lights: within the cone), in
 * order of distance. Returns their number; beyond TY_LIT_SEGMENTS_MAX the segments with the shortest gaps are merged.
 * Points outside the map are lit. direction: unit. */
int32_t ty_shadow_lit_segments(const ty_shadow_hierarchy* map, ty_vec origin, ty_vec direction, float from, float to,
                               float segments[TY_LIT_SEGMENTS_MAX][2]);

/* A packet of up to TY_SHADOW_RAYS_MAX rays from one origin: their intervals [from, to] and, as results, the lit
 * segments of each. */
typedef struct ty_shadow_rays {
    int32_t count;
    ty_vec origin, direction[TY_SHADOW_RAYS_MAX];
    float from[TY_SHADOW_RAYS_MAX], to[TY_SHADOW_RAYS_MAX];
    int32_t counts[TY_SHADOW_RAYS_MAX];
    float segments[TY_SHADOW_RAYS_MAX][TY_LIT_SEGMENTS_MAX][2];
} ty_shadow_rays;
void ty_shadow_lit_segments_of(const ty_shadow_hierarchy* map, ty_shadow_rays* rays);

/* The visibility of a surface point from the light: the bilinear mean over the four texels around it of whether a texel
 * is in front of the point's tangent plane by more than `slack`, m. normal: unit. *sure: whether all four agree and
 * none is between `slack` and `close` in front, where it may be the surface itself or one that touches it. */
float ty_shadow_visibility(const ty_shadow_hierarchy* map, ty_vec point, ty_vec normal, float slack, float close,
                           bool* sure);

#endif
