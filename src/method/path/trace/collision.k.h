/* Collision sampling along a ray: in closed form in homogeneous media, by delta tracking in any.
 *
 * Colour: each random choice is drawn from a mixture over channels weighted by the path's throughput, and the
 * throughput is divided by the density of the mixture. This is one-sample MIS over wavelengths with the balance
 * heuristic (spectral MIS, Wilkie 2014); the sum of the throughput over channels never grows. */
#ifndef TY_METHOD_PATH_TRACE_COLLISION_K_H
#define TY_METHOD_PATH_TRACE_COLLISION_K_H

#include "direct/media/transmittance.k.h"

typedef struct ty_collision {
    float t;
    int32_t medium;
} ty_collision;

TY_FN float ty_sum3(const float v[3]) {
    return v[0] + v[1] + v[2];
}

TY_FN float ty_max3(const float v[3]) {
    return ty_maxf(v[0], ty_maxf(v[1], v[2]));
}

/* Samples an index with probability proportional to weights[0..count), whose sum is positive; *u is remapped to [0, 1).
 */
TY_FN int32_t ty_sample_discrete(const float* weights, int32_t count, float sum, float* u) {
    float target = *u * sum;
    int32_t i = 0;
    while (i + 1 < count && target >= weights[i]) target -= weights[i++];
    *u = ty_clampf(target / ty_maxf(weights[i], 1e-37f), 0.0f, 0x1.fffffep-1f);
    return i;
}

/* ---- homogeneous media: closed forms ---- */

/* Optical depth of a point p in a homogeneous medium: the least over channels and over ways out, exact for boxes, and
 * for spheres that no map distorts; 0 for other bounds. p: in the space of medium->to_bounds. */
TY_FN float ty_medium_depth(TY_GLOBAL const ty_medium_view* medium, ty_vec p) {
    TY_GLOBAL const float* map = medium->to_bounds;
    if (medium->bounds != TY_BOUNDED_BOX && medium->bounds != TY_BOUNDED_SPHERE) return 0.0f;
    const float to_plane[3] = {1.0f - fabsf(p.x), 1.0f - fabsf(p.y), 1.0f - fabsf(p.z)};
    const float to_sphere = 1.0f - sqrtf(ty_dot(p, p));
    float distance = TY_FLOAT_MAX;
    for (int a = 0; a < 3; ++a) {
        const ty_vec row = ty_vec_make(map[4 * a], map[4 * a + 1], map[4 * a + 2]);
        const float inside = medium->bounds == TY_BOUNDED_BOX ? to_plane[a] : to_sphere;
        distance = ty_minf(distance, inside / sqrtf(ty_dot(row, row)));
    }
    return ty_minf(medium->sigma_t[0], ty_minf(medium->sigma_t[1], medium->sigma_t[2])) * distance;
}

/* Probability of a collision within an optical depth: 1 - exp(-depth), without cancellation for thin media. */
TY_FN float ty_collision_probability(float depth) {
    if (depth > 0.03f) return 1.0f - ty_expf(-depth);
    return depth * (1.0f - depth * (0.5f - depth * (1.0f / 6.0f - depth * (1.0f / 24.0f))));
}

/* Optical depth of a collision for a random number below the collision probability: -ln(1 - fraction), the inverse of
 * ty_collision_probability. */
TY_FN float ty_sample_collision_depth(float fraction) {
    if (fraction > 0.03f) return -ty_logf(1.0f - fraction);
    return fraction * (1.0f + fraction * (0.5f + fraction * (1.0f / 3.0f + fraction * 0.25f)));
}

/* Optical depth per channel of homogeneous spans from the ray's origin to t. */
TY_FN void ty_spans_optical_depth(TY_GLOBAL const ty_medium_view* media, const ty_spans* spans, float t,
                                  float depth[3]) {
    for (int c = 0; c < 3; ++c) depth[c] = 0.0f;
    for (int32_t i = 0; i < spans->count; ++i) {
        const float length = ty_minf(t, spans->leave[i]) - spans->enter[i];
        if (length > 0.0f)
            for (int c = 0; c < 3; ++c) depth[c] += media[spans->medium[i]].sigma_t[c] * length;
    }
}

/* The distance t at which a channel's optical depth equals depth, which is below that of all spans. */
TY_FN float ty_spans_invert_optical_depth(TY_GLOBAL const ty_medium_view* media, const ty_spans* spans, int32_t channel,
                                          float depth) {
    if (spans->count == 1) return spans->enter[0] + depth / media[spans->medium[0]].sigma_t[channel];
    float at = -1.0f;
    for (;;) {
        float next = TY_FLOAT_MAX, sigma = 0.0f;
        for (int32_t i = 0; i < spans->count; ++i) {
            if (spans->enter[i] <= at && spans->leave[i] > at) sigma += media[spans->medium[i]].sigma_t[channel];
            if (spans->enter[i] > at) next = ty_minf(next, spans->enter[i]);
            if (spans->leave[i] > at) next = ty_minf(next, spans->leave[i]);
        }
        if (next >= TY_FLOAT_MAX || (sigma > 0.0f && at + depth / sigma <= next))
            return sigma > 0.0f ? at + depth / sigma : at;
        depth -= sigma * (next - at);
        at = next;
    }
}

/* Emitted radiance of homogeneous media at the ray's origin, per channel: the line integral of transmittance times
 * emission coefficient in closed form. */
TY_FN void ty_spans_emitted_radiance(TY_GLOBAL const ty_medium_view* media, const ty_spans* spans, float radiance[3]) {
    float passed[3] = {1.0f, 1.0f, 1.0f};
    float at = 0.0f;
    for (int c = 0; c < 3; ++c) radiance[c] = 0.0f;
    for (;;) {
        float next = TY_FLOAT_MAX, sigma_t[3] = {0.0f, 0.0f, 0.0f}, emission[3] = {0.0f, 0.0f, 0.0f};
        for (int32_t i = 0; i < spans->count; ++i) {
            if (spans->enter[i] > at) next = ty_minf(next, spans->enter[i]);
            if (spans->leave[i] > at) next = ty_minf(next, spans->leave[i]);
            if (spans->enter[i] > at || spans->leave[i] <= at) continue;
            TY_GLOBAL const ty_medium_view* medium = &media[spans->medium[i]];
            for (int c = 0; c < 3; ++c) {
                sigma_t[c] += medium->sigma_t[c];
                emission[c] += (medium->sigma_t[c] - medium->sigma_s[c]) * medium->emission[c];
            }
        }
        const bool last = next >= TY_FLOAT_MAX;
        for (int c = 0; c < 3; ++c) {
            if (!(sigma_t[c] > 0.0f)) continue;
            const float depth = sigma_t[c] * (next - at);
            radiance[c] += passed[c] * (last ? 1.0f : ty_collision_probability(depth)) * emission[c] / sigma_t[c];
            passed[c] *= last ? 0.0f : ty_expf(-depth);
        }
        if (last) return;
        at = next;
    }
}

/* Samples a collision in the spans with u in [0, 1), given that one occurs. beta: in, the throughput at the ray's
 * origin; out, the throughput after scattering without the phase function, whose mean is the integral over the spans.
 * collided: collision probability per channel. False: nothing scatters there. */
TY_FN bool ty_sample_homogeneous_collision(TY_GLOBAL const ty_medium_view* media, const ty_spans* spans,
                                           const float collided[3], float u, ty_sampler* random, float beta[3],
                                           ty_collision* out) {
    float weight[3];
    for (int c = 0; c < 3; ++c) weight[c] = beta[c] * collided[c];
    const float sum = ty_sum3(weight);
    if (!(sum > 0.0f)) return false;
    const bool gray = spans->count == 1 && media[spans->medium[0]].gray != 0;
    const int32_t channel = gray ? 0 : ty_sample_discrete(weight, 3, sum, &u);
    const float depth = ty_sample_collision_depth(ty_minf(u, 0x1.fffffep-1f) * collided[channel]);
    out->t = ty_spans_invert_optical_depth(media, spans, channel, depth);
    if (gray) {
        TY_GLOBAL const ty_medium_view* medium = &media[spans->medium[0]];
        out->medium = spans->medium[0];
        out->t = ty_minf(out->t, spans->leave[0]);
        for (int c = 0; c < 3; ++c) beta[c] *= collided[0] * medium->uniform_albedo[c];
        return ty_sum3(beta) > 0.0f;
    }
    /* The medium that scatters, and the density of t in the mixture over channels. */
    float depths[3], scattering[TY_SPANS_MAX], sigma_t[3] = {0.0f, 0.0f, 0.0f}, total = 0.0f,
                                               density = 0.0f; /* times sum */
    ty_spans_optical_depth(media, spans, out->t, depths);
    for (int32_t i = 0; i < spans->count; ++i) {
        scattering[i] = 0.0f;
        if (out->t < spans->enter[i] || out->t > spans->leave[i]) continue;
        TY_GLOBAL const ty_medium_view* medium = &media[spans->medium[i]];
        for (int c = 0; c < 3; ++c) {
            sigma_t[c] += medium->sigma_t[c];
            scattering[i] += beta[c] * medium->sigma_s[c];
        }
        total += scattering[i];
    }
    if (!(total > 0.0f)) return false;
    for (int c = 0; c < 3; ++c) {
        depths[c] = ty_expf(-depths[c]);
        density += beta[c] * sigma_t[c] * depths[c];
    }
    float pick = spans->count == 1 ? 0.0f : ty_rng_uniform(random);
    const int32_t i = spans->count == 1 ? 0 : ty_sample_discrete(scattering, spans->count, total, &pick);
    out->medium = spans->medium[i];
    if (!(density > 0.0f) || !(scattering[i] > 0.0f)) return false;
    const float factor = sum / density * (total / scattering[i]);
    for (int c = 0; c < 3; ++c) beta[c] *= media[out->medium].sigma_s[c] * depths[c] * factor;
    return true;
}

/* ---- heterogeneous media: null collisions ---- */

/* Tentative collisions of one medium along a ray, sampled from the piecewise constant majorant. */
typedef struct ty_majorant_tracker {
    ty_majorant_dda bricks;
    float t; /* distance of the tentative collision; TY_FLOAT_MAX past the last */
} ty_majorant_tracker;

/* The density of tentative collisions. */
TY_FN float ty_majorant_tracker_density(const ty_majorant_tracker* tracker) {
    return ty_maxf(tracker->bricks.majorant, tracker->bricks.medium->emission_majorant);
}

TY_FN void ty_majorant_tracker_next(ty_majorant_tracker* tracker, float u) {
    float left = ty_exponential(u);
    float t = tracker->t;
    for (;;) {
        const float rate = ty_majorant_tracker_density(tracker) * tracker->bricks.medium->sigma_t_max;
        const float depth = (tracker->bricks.leave - t) * rate;
        if (left < depth) {
            tracker->t = t + ty_maxf(left / rate, TY_MIN_COLLISION_STEP * t);
            return;
        }
        left -= depth;
        if (!ty_majorant_dda_next(&tracker->bricks)) break;
        t = tracker->bricks.enter;
    }
    tracker->t = TY_FLOAT_MAX;
}

TY_FN void ty_majorant_tracker_begin(ty_majorant_tracker* tracker, TY_GLOBAL const ty_medium_view* medium,
                                     ty_vec origin, ty_vec direction, float enter, float leave, float u) {
    ty_majorant_dda_begin(&tracker->bricks, medium, origin, direction, enter, leave);
    tracker->t = enter;
    ty_majorant_tracker_next(tracker, u);
}

/* Single-scattering albedo at a tentative collision. */
TY_FN void ty_majorant_tracker_albedo(const ty_majorant_tracker* tracker, ty_vec origin, ty_vec direction,
                                      float albedo[3]) {
    ty_medium_albedo(tracker->bricks.medium, ty_mad(origin, direction, tracker->t), albedo);
}

/* Accepts a tentative collision as real or null and updates beta. A gray medium whose minorant already decides needs no
 * density lookup. Emission is accumulated at every tentative collision. */
TY_FN bool ty_majorant_tracker_collides(const ty_majorant_tracker* tracker, ty_vec origin, ty_vec direction,
                                        ty_sampler* random, float beta[3], float emitted[3]) {
    TY_GLOBAL const ty_medium_view* medium = tracker->bricks.medium;
    const float high = ty_majorant_tracker_density(tracker);
    const float u = ty_rng_uniform(random);
    float albedo[3];
    if (medium->gray != 0 && medium->emits == 0) {
        const bool real = u * high < tracker->bricks.minorant ||
                          u * high < ty_majorant_dda_density(&tracker->bricks, tracker->t, random);
        if (real) {
            ty_majorant_tracker_albedo(tracker, origin, direction, albedo);
            for (int c = 0; c < 3; ++c) beta[c] *= albedo[c];
        }
        return real;
    }
    const float fraction = ty_majorant_dda_density(&tracker->bricks, tracker->t, random) / (high * medium->sigma_t_max);
    if (medium->emits != 0) {
        float emission[3];
        ty_medium_emission_coefficient(medium, ty_mad(origin, direction, tracker->t), emission);
        for (int c = 0; c < 3; ++c) emitted[c] += beta[c] * fraction * emission[c];
    }
    float real = 0.0f;
    for (int c = 0; c < 3; ++c) real += beta[c] * medium->sigma_t[c];
    const float probability = fraction * real / ty_sum3(beta);
    if (u < probability) {
        ty_majorant_tracker_albedo(tracker, origin, direction, albedo);
        for (int c = 0; c < 3; ++c) beta[c] *= fraction * medium->sigma_t[c] * albedo[c] / probability;
        return true;
    }
    for (int c = 0; c < 3; ++c) beta[c] *= ty_maxf(0.0f, 1.0f - fraction * medium->sigma_t[c]) / (1.0f - probability);
    return false;
}

/* Delta tracking (Woodcock 1965): the first real collision in the spans. beta is updated as in
 * ty_sample_homogeneous_collision; false means that the light crossed all spans, and beta then accounts for that.
 * Overlapping media are independent processes, of which the earliest event counts. Emission times throughput is added
 * to emitted at every tentative collision. */
TY_FN bool ty_delta_tracking(TY_GLOBAL const ty_medium_view* media, const ty_spans* spans, ty_vec origin,
                             ty_vec direction, ty_sampler* random, float beta[3], float emitted[3], ty_collision* out) {
    ty_majorant_tracker trackers[TY_SPANS_MAX];
    for (int32_t i = 0; i < spans->count; ++i)
        ty_majorant_tracker_begin(&trackers[i], &media[spans->medium[i]], origin, direction, spans->enter[i],
                                  spans->leave[i], i == 0 ? ty_sobol_next(random) : ty_rng_uniform(random));
    for (;;) {
        int32_t first = 0;
        for (int32_t i = 1; i < spans->count; ++i)
            if (trackers[i].t < trackers[first].t) first = i;
        if (trackers[first].t >= TY_FLOAT_MAX) return false;
        if (ty_majorant_tracker_collides(&trackers[first], origin, direction, random, beta, emitted)) {
            out->t = trackers[first].t;
            out->medium = spans->medium[first];
            return true;
        }
        ty_majorant_tracker_next(&trackers[first], ty_rng_uniform(random));
    }
}

#endif
