/* One point of the media along a ray, found by chance, in the place of all of them. */
#ifndef TY_BAKE_FOG_POINT_K_H
#define TY_BAKE_FOG_POINT_K_H

#include "method/path/flight.k.h"

/* Chosen among the pieces of a ray that are offered one after the other, by how much of the light that comes from there
 * they stop. */
typedef struct ty_fog_point {
    float u;   /* random, in [0, 1); what choices leave of it */
    float all; /* of all pieces: what they stop, mean of the channels */
    TY_GLOBAL const ty_medium_view* medium; /* the chosen piece's; NULL: there is none */
    float enter, leave;                     /* m along the ray */
    float depth[3], passing[3];             /* of the piece; from its beginning to the ray's, by its medium alone */
    TY_GLOBAL const ty_medium_view* last;   /* whose pieces are on offer, and what it leaves of light so far */
    float left[3];
} ty_fog_point;

TY_FN ty_fog_point ty_fog_point_begin(float u) {
    ty_fog_point point;
    point.u = u;
    point.all = 0.0f;
    point.medium = point.last = NULL;
    return point;
}

TY_FN void ty_fog_point_offer(ty_fog_point* point, TY_GLOBAL const ty_medium_view* medium, float matter, float enter,
                              float leave) {
    float depth[3], stops = 0.0f;
    if (point->last != medium) {
        point->last = medium;
        for (int c = 0; c < 3; ++c) point->left[c] = 1.0f;
    }
    for (int c = 0; c < 3; ++c) {
        depth[c] = medium->sigma_t[c] * matter;
        stops += (1.0f / 3.0f) * point->left[c] * ty_stopped(depth[c]);
    }
    if (stops > 0.0f) {
        point->all += stops;
        const float chance = stops / point->all;
        if (point->u < chance) {
            point->u = point->u / chance;
            point->medium = medium;
            point->enter = enter;
            point->leave = leave;
            for (int c = 0; c < 3; ++c) {
                point->depth[c] = depth[c];
                point->passing[c] = point->left[c];
            }
        } else
            point->u = (point->u - chance) / (1.0f - chance);
    }
    for (int c = 0; c < 3; ++c) point->left[c] *= ty_expf(-depth[c]);
}

/* How far along the ray the point is. weight: what the media stop of light from there and beyond, in its place; by its
 * own medium alone. left: what that leaves of light from there. */
TY_FN float ty_fog_point_place(const ty_fog_point* point, float weight[3], float left[3]) {
    /* A channel by its share of what the piece stops, then as that channel stops it: no channel's weight is ever more
     * than thrice all's. */
    float u = point->u, share[3], sum = 0.0f, total = 0.0f;
    for (int c = 0; c < 3; ++c) sum += share[c] = point->passing[c] * ty_stopped(point->depth[c]);
    const float depth = point->depth[ty_pick(share, 3, sum, &u)];
    const float part = depth > 0.0f ? ty_minf(1.0f, ty_stopping_depth(u * ty_stopped(depth)) / depth) : u;
    for (int c = 0; c < 3; ++c) {
        left[c] = point->passing[c] * ty_expf(-point->depth[c] * part);
        total += weight[c] = point->depth[c] * left[c];
    }
    for (int c = 0; c < 3; ++c) weight[c] *= total > 0.0f ? 3.0f * point->all / total : 0.0f;
    return ty_lerpf(point->enter, point->leave, part);
}

#endif
