/* Transmittance of all media between two points of a ray: exact for homogeneous media; residual ratio tracking (Novak
 * et al. 2014) in grids, with the minimum density of each brick as control variate. */
#ifndef TY_DIRECT_MEDIA_TRANSMITTANCE_K_H
#define TY_DIRECT_MEDIA_TRANSMITTANCE_K_H

#include "scene/media/spans.k.h"

/* Multiplies transmittance[3] by an unbiased estimate for one medium over [enter, leave]; direction is unit. Russian
 * roulette ends estimates below 0.1. */
TY_FN void ty_track_transmittance(TY_GLOBAL const ty_medium_view* medium, ty_vec origin, ty_vec direction, float enter,
                                  float leave, ty_sampler* random, float transmittance[3]) {
    ty_majorant_dda bricks;
    float min_integral = 0.0f; /* integral of the bricks' minimum density */
    float left = ty_exponential(ty_rng_uniform(random));
    float track[3] = {1.0f, 1.0f, 1.0f};
    ty_majorant_dda_begin(&bricks, medium, origin, direction, enter, leave);
    while (ty_majorant_dda_next(&bricks)) {
        const float range = bricks.majorant - bricks.minorant;
        const float rate = range * medium->sigma_t_max;
        float t = bricks.enter;
        min_integral += bricks.minorant * (bricks.leave - bricks.enter);
        while (left < (bricks.leave - t) * rate) {
            t += ty_maxf(left / rate, TY_MIN_COLLISION_STEP * t);
            const float density = ty_majorant_dda_density(&bricks, t, random);
            const float fraction = (density - bricks.minorant) / rate;
            for (int c = 0; c < 3; ++c) track[c] *= ty_maxf(0.0f, 1.0f - fraction * medium->sigma_t[c]);
            const float largest = ty_maxf(track[0], ty_maxf(track[1], track[2]));
            if (largest < 0.1f) {
                if (ty_rng_uniform(random) * 0.2f >= largest) {
                    for (int c = 0; c < 3; ++c) transmittance[c] = 0.0f;
                    return;
                }
                for (int c = 0; c < 3; ++c) track[c] *= 0.2f / largest;
            }
            left = ty_exponential(ty_rng_uniform(random));
        }
        left -= (bricks.leave - t) * rate;
    }
    for (int c = 0; c < 3; ++c) transmittance[c] *= track[c] * ty_expf(-min_integral * medium->sigma_t[c]);
}

/* Accumulates one segment of a ray inside a medium: homogeneous media add to depth. */
TY_FN void ty_pass_stretch(TY_GLOBAL const ty_medium_view* medium, ty_vec origin, ty_vec direction, float enter,
                           float leave, ty_sampler* random, float depth[3], float transmittance[3]) {
    if (medium->has_grid != 0)
        ty_track_transmittance(medium, origin, direction, enter, leave, random, transmittance);
    else
        for (int c = 0; c < 3; ++c) depth[c] += medium->sigma_t[c] * (leave - enter);
}

/* Transmittance per channel through media[0..count) over [0, far] of a ray with unit direction. Most media are one
 * segment, for which a list of spans would cost more than it saves. */
TY_FN void ty_transmittance(TY_GLOBAL const ty_medium_view* media, int32_t count, ty_vec origin, ty_vec direction,
                            float far, ty_sampler* random, float transmittance[3]) {
    float depth[3] = {0.0f, 0.0f, 0.0f};
    for (int c = 0; c < 3; ++c) transmittance[c] = 1.0f;
    for (int32_t m = 0; m < count; ++m) {
        float enter = 0.0f, leave = far;
        if (!ty_medium_interval(&media[m], origin, direction, &enter, &leave)) continue;
        if (media[m].bounds != TY_BOUNDED_MESH) {
            ty_pass_stretch(&media[m], origin, direction, enter, leave, random, depth, transmittance);
            continue;
        }
        ty_spans spans;
        spans.count = spans.heterogeneous = spans.emits = 0;
        ty_spans_add_shell(&spans, media, m, origin, direction, enter, leave);
        for (int32_t i = 0; i < spans.count; ++i)
            ty_pass_stretch(&media[m], origin, direction, spans.enter[i], spans.leave[i], random, depth, transmittance);
    }
    for (int c = 0; c < 3; ++c) transmittance[c] *= ty_expf(-depth[c]);
}

#endif
