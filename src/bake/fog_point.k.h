/* One point of the media along a ray, found by chance, in the place of all of them. */
#ifndef TY_BAKE_FOG_POINT_K_H
#define TY_BAKE_FOG_POINT_K_H

#include "method/path/collision.k.h"

/* Chosen among the pieces of a ray that are offered one after the other, by how much of the light that comes from there
 * they stop. */
typedef struct ty_fog_point {
    float u;                                /* random, in [0, 1): where in the piece */
    ty_sampler* random;                     /* which piece */
    float all;                              /* of all pieces: what they stop, mean of the channels */
    TY_GLOBAL const ty_medium_view* medium; /* the chosen piece's; NULL: there is none */
    float enter, leave;                     /* m along the ray */
    float matter, passing[3];               /* of the piece; up to it, by its medium alone */
    TY_GLOBAL const ty_medium_view* last;   /* whose pieces are on offer, and what it leaves of light so far */
    float left[3];
} ty_fog_point;

TY_FN ty_fog_point ty_fog_point_begin(float u, ty_sampler* random) {
    ty_fog_point point;
    point.random = random;
    point.u = u;
    point.all = 0.0f;
    point.medium = point.last = NULL;
    return point;
}

TY_FN void ty_fog_point_offer(ty_fog_point* point, TY_GLOBAL const ty_medium_view* medium, float matter, float enter,
                              float leave) {
    float stopped[3], stops = 0.0f;
    if (point->last != medium) {
        point->last = medium;
        for (int c = 0; c < 3; ++c) point->left[c] = 1.0f;
    }
    for (int c = 0; c < 3; ++c) {
        stopped[c] = c > 0 && medium->gray != 0
                         ? stopped[0]
                         : point->left[c] * ty_collision_probability(medium->sigma_t[c] * matter);
        stops += (1.0f / 3.0f) * stopped[c];
    }
    point->all += stops;
    if (stops > 0.0f && (point->medium == NULL || ty_rng_uniform(point->random) * point->all < stops)) {
        point->medium = medium;
        point->matter = matter;
        point->enter = enter;
        point->leave = leave;
        for (int c = 0; c < 3; ++c) point->passing[c] = point->left[c];
    }
    for (int c = 0; c < 3; ++c) point->left[c] -= stopped[c];
}

/* How far along the ray the point is. weight: what the media stop of light from there and beyond, in its place; by its
 * own medium alone. left: what that leaves of light from there. */
TY_FN float ty_fog_point_place(const ty_fog_point* point, float weight[3], float left[3]) {
    const float* sigma_t = point->medium->sigma_t;
    const bool gray = point->medium->gray != 0;
    /* A channel by its share of what the piece stops, then as that channel stops it: no channel's weight is ever more
     * than thrice all's. */
    float u = point->u, share[3], sum = 0.0f, total = 0.0f;
    int32_t channel = 0;
    if (!gray) {
        for (int c = 0; c < 3; ++c)
            sum += share[c] = point->passing[c] * ty_collision_probability(sigma_t[c] * point->matter);
        channel = ty_sample_discrete(share, 3, sum, &u);
    }
    const float depth = sigma_t[channel] * point->matter;
    const float part =
        depth > 0.0f ? ty_minf(1.0f, ty_sample_collision_depth(u * ty_collision_probability(depth)) / depth) : u;
    for (int c = 0; c < 3; ++c) {
        left[c] = c > 0 && gray ? left[0] : point->passing[c] * ty_expf(-sigma_t[c] * point->matter * part);
        total += weight[c] = sigma_t[c] * left[c];
    }
    for (int c = 0; c < 3; ++c)
        weight[c] = gray ? point->all : total > 0.0f ? 3.0f * point->all * weight[c] / total : 0.0f;
    return ty_lerpf(point->enter, point->leave, part);
}

#endif
