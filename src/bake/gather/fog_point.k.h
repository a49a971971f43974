/* One random sample point of the media along a ray, which represents all of them. */
#ifndef TY_BAKE_GATHER_FOG_POINT_K_H
#define TY_BAKE_GATHER_FOG_POINT_K_H

#include "method/path/trace/collision.k.h"

/* Reservoir sampling over the pieces of a ray in order, each weighted by the probability that the ray collides in it.
 */
typedef struct ty_fog_point {
    float u;                                /* uniform in [0, 1): position in the piece */
    ty_sampler* random;                     /* selects the piece */
    float total;                            /* collision probability summed over all pieces, channel mean */
    TY_GLOBAL const ty_medium_view* medium; /* medium of the chosen piece; NULL: none */
    float enter, leave;                     /* m along the ray */
    float optical_length,
        transmitted[3]; /* of the piece, in metres at density 1; transmittance up to it by its own medium */
    TY_GLOBAL const ty_medium_view* current; /* medium of the latest piece, and its transmittance so far */
    float remaining[3];
} ty_fog_point;

TY_FN ty_fog_point ty_fog_point_begin(float u, ty_sampler* random) {
    ty_fog_point point;
    point.random = random;
    point.u = u;
    point.total = 0.0f;
    point.medium = point.current = NULL;
    return point;
}

TY_FN void ty_fog_point_add_piece(ty_fog_point* point, TY_GLOBAL const ty_medium_view* medium, float optical_length,
                                  float enter, float leave) {
    float collided[3], collision = 0.0f;
    if (point->current != medium) {
        point->current = medium;
        for (int c = 0; c < 3; ++c) point->remaining[c] = 1.0f;
    }
    for (int c = 0; c < 3; ++c) {
        collided[c] = c > 0 && medium->gray != 0
                          ? collided[0]
                          : point->remaining[c] * ty_collision_probability(medium->sigma_t[c] * optical_length);
        collision += (1.0f / 3.0f) * collided[c];
    }
    point->total += collision;
    if (collision > 0.0f && (point->medium == NULL || ty_rng_uniform(point->random) * point->total < collision)) {
        point->medium = medium;
        point->optical_length = optical_length;
        point->enter = enter;
        point->leave = leave;
        for (int c = 0; c < 3; ++c) point->transmitted[c] = point->remaining[c];
    }
    for (int c = 0; c < 3; ++c) point->remaining[c] -= collided[c];
}

/* Samples the distance of the point along the ray. weight: sample weight per channel, an unbiased estimate of the
 * collision probability along the ray; left: transmittance up to the point; both by its own medium alone. */
TY_FN float ty_fog_point_sample_distance(const ty_fog_point* point, float weight[3], float left[3]) {
    const float* sigma_t = point->medium->sigma_t;
    const bool gray = point->medium->gray != 0;
    /* One channel is chosen in proportion to its collision probability in the piece and then sampled exponentially, so
     * the weight of a channel never exceeds three times the total. */
    float u = point->u, chance[3], chance_sum = 0.0f, weight_sum = 0.0f;
    int32_t channel = 0;
    if (!gray) {
        for (int c = 0; c < 3; ++c)
            chance_sum += chance[c] =
                point->transmitted[c] * ty_collision_probability(sigma_t[c] * point->optical_length);
        channel = ty_sample_discrete(chance, 3, chance_sum, &u);
    }
    const float depth = sigma_t[channel] * point->optical_length;
    const float fraction =
        depth > 0.0f ? ty_minf(1.0f, ty_sample_collision_depth(u * ty_collision_probability(depth)) / depth) : u;
    for (int c = 0; c < 3; ++c) {
        left[c] =
            c > 0 && gray ? left[0] : point->transmitted[c] * ty_expf(-sigma_t[c] * point->optical_length * fraction);
        weight_sum += weight[c] = sigma_t[c] * left[c];
    }
    for (int c = 0; c < 3; ++c)
        weight[c] = gray ? point->total : weight_sum > 0.0f ? 3.0f * point->total * weight[c] / weight_sum : 0.0f;
    return ty_lerpf(point->enter, point->leave, fraction);
}

#endif
