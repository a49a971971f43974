/* Distances along the camera's rays in a homogeneous medium, sampled in proportion to the light that reaches the ray's
 * origin from there, by a guide: from each cell that the ray passes, and from the surface at its end. */
#ifndef TY_METHOD_PATH_TRACE_GUIDED_DISTANCE_K_H
#define TY_METHOD_PATH_TRACE_GUIDED_DISTANCE_K_H

#include "base/luminance.k.h"
#include "method/path/trace/collision.k.h"
#include "method/path/trace/light_path.k.h"

enum { TY_GUIDE_SEGMENTS_MAX = 3 * TY_GUIDE_CELLS_MAX + 1 };

/* Parts of a ray in a medium of extinction sigma: one per cell. */
typedef struct ty_guide_segments {
    int32_t count;
    float sigma, enter;                      /* 1/m, m: start of the medium */
    float sum;                               /* expected radiance of the ray, surface included */
    float surface;                           /* the surface's part */
    float from[TY_GUIDE_SEGMENTS_MAX + 1];   /* m, and the end of the last one */
    float passed[TY_GUIDE_SEGMENTS_MAX + 1]; /* transmittance up to there */
    float radiance[TY_GUIDE_SEGMENTS_MAX];   /* expected radiance that a part scatters to the origin */
} ty_guide_segments;

/* The parts of a ray in a span of a medium. */
TY_FN void ty_guide_segments_find(ty_guide_segments* s, const ty_path* path, const ty_medium_view* medium, float enter,
                                  float leave) {
    const ty_guide* guide = path->request->guide;
    const ty_vec travel = ty_scale(path->direction, -1.0f);
    const float sigma_s = ty_luminance(medium->sigma_s[0], medium->sigma_s[1], medium->sigma_s[2]);
    ty_guide_walk walk;
    s->count = 0;
    s->sigma = ty_luminance(medium->sigma_t[0], medium->sigma_t[1], medium->sigma_t[2]);
    s->enter = enter;
    s->sum = s->surface = 0.0f;
    if (!ty_guide_walk_begin(&walk, &guide->cells, path->origin, path->direction, enter, leave)) return;
    const float albedo = sigma_s / s->sigma;
    float passed = ty_exp_neg(ty_minf(s->sigma * (walk.from - enter), 87.0f));
    do {
        const float after = ty_exp_neg(ty_minf(s->sigma * (walk.to - enter), 87.0f));
        const ty_guide_light* light = &guide->light[ty_guide_walk_cell(&walk)];
        s->from[s->count] = walk.from;
        s->passed[s->count] = passed;
        const float radiance = albedo * (passed - after) * ty_guide_scattered(light, travel, medium->g[1]);
        s->radiance[s->count++] = radiance;
        s->sum += radiance;
        s->from[s->count] = walk.to;
        s->passed[s->count] = passed = after;
    } while (s->count < TY_GUIDE_SEGMENTS_MAX && ty_guide_walk_next(&walk));
}

/* The surface at the ray's end, behind a transmittance. */
TY_FN void ty_guide_segments_add_surface(ty_guide_segments* s, const ty_path* path, const ty_intersection* end,
                                         float transmittance) {
    const ty_guide_light* light = ty_guide_light_before(path->request->guide, end->hit.position, end->point.ng);
    if (light == NULL) return;
    const float* albedo = end->point.albedo;
    s->surface = transmittance * ty_luminance(albedo[0], albedo[1], albedo[2]) * (1.0f / TY_PI) *
                 ty_guide_irradiance(light, end->point.ng);
    s->sum += s->surface;
}

/* The density of a distance, 1/m, within a part. */
TY_FN float ty_guide_segments_pdf(const ty_guide_segments* s, int32_t part, float t) {
    const float within = ty_maxf(s->passed[part] - s->passed[part + 1], 1e-37f);
    return s->radiance[part] / s->sum * s->sigma * ty_exp_neg(ty_minf(s->sigma * (t - s->enter), 87.0f)) / within;
}

/* A distance within a part, u in [0, 1). */
TY_FN float ty_guide_segments_sample(const ty_guide_segments* s, int32_t part, float u) {
    const float length = s->from[part + 1] - s->from[part];
    const float collided = ty_collision_probability(ty_minf(s->sigma * length, 87.0f));
    return ty_minf(s->from[part] + ty_sample_collision_depth(u * collided) / s->sigma, s->from[part + 1]);
}

/* The part of a distance; -1: it is outside of the cells. */
TY_FN int32_t ty_guide_segments_part(const ty_guide_segments* s, float t) {
    if (s->count == 0 || t < s->from[0] || t >= s->from[s->count]) return -1;
    int32_t low = 0, high = s->count;
    while (high - low > 1) {
        const int32_t center = (low + high) / 2;
        if (t >= s->from[center])
            low = center;
        else
            high = center;
    }
    return low;
}

/* The next event of a path in a homogeneous medium. */
typedef struct ty_guided_event {
    bool collides;
    float t;
    float analog; /* throughput of the event over that before it, without weights of sampling */
} ty_guided_event;

/* The next event, from the mixture of guided sampling and of that in proportion to throughput: `colliding` and
 * `reflecting`, the sums over channels of what scatters and of what a surface reflects. transmitted: throughput at the
 * surface. Updates beta. False: the guide says nothing about the ray. */
TY_FN_CALLED bool ty_path_sample_guided_event(ty_path* path, const ty_spans* spans, const ty_intersection* end,
                                              const float transmitted[3], float colliding, float reflecting,
                                              ty_guided_event* event) {
    const ty_medium_view* medium = &path->media[spans->medium[0]];
    const float enter = spans->enter[0], leave = spans->leave[0];
    const float sum = colliding + reflecting, before = ty_sum3(path->beta), alpha = path->request->guide->distances;
    ty_guide_segments s;
    ty_guide_segments_find(&s, path, medium, enter, leave);
    if (s.count == 0) return false;
    if (reflecting > 0.0f)
        ty_guide_segments_add_surface(&s, path, end, ty_exp_neg(ty_minf(s.sigma * (leave - enter), 87.0f)));
    path->expected = s.sum;
    if (!(s.sum > 1e-30f)) return false;
    float u = ty_sobol_next(&path->random);
    int32_t part = -1;
    bool reflects;
    if (u < alpha) {
        float target = u / alpha * s.sum;
        reflects = target < s.surface;
        target -= s.surface;
        if (!reflects) {
            part = 0;
            while (part + 1 < s.count && target >= s.radiance[part]) target -= s.radiance[part++];
            const float rest = ty_clampf(target / ty_maxf(s.radiance[part], 1e-37f), 0.0f, 0x1.fffffep-1f);
            event->t = ty_guide_segments_sample(&s, part, rest);
        }
    } else {
        u = ty_minf((u - alpha) / (1.0f - alpha), 0x1.fffffep-1f) * sum;
        reflects = u < reflecting;
        if (!reflects) {
            float weight[3];
            u = ty_minf((u - reflecting) / colliding, 0x1.fffffep-1f);
            for (int c = 0; c < 3; ++c)
                weight[c] = path->beta[c] * ty_collision_probability(medium->sigma_t[c] * (leave - enter));
            const int32_t channel = ty_sample_discrete(weight, 3, ty_sum3(weight), &u);
            const float collided = ty_collision_probability(medium->sigma_t[channel] * (leave - enter));
            event->t = ty_minf(enter + ty_sample_collision_depth(u * collided) / medium->sigma_t[channel], leave);
            part = ty_guide_segments_part(&s, event->t);
        }
    }
    event->collides = !reflects;
    if (reflects) {
        const float p = alpha * s.surface / s.sum + (1.0f - alpha) * reflecting / sum;
        event->analog = sum / before * ty_sum3(transmitted) / reflecting;
        for (int c = 0; c < 3; ++c) path->beta[c] = transmitted[c] / p;
        return true;
    }
    float scattered[3], density = 0.0f;
    for (int c = 0; c < 3; ++c) {
        const float passed = path->beta[c] * ty_expf(-medium->sigma_t[c] * (event->t - enter));
        density += passed * medium->sigma_t[c];
        scattered[c] = passed * medium->sigma_s[c];
    }
    event->analog = density > 0.0f ? sum / before * ty_sum3(scattered) / density : 0.0f;
    density *= (1.0f - alpha) / sum;
    if (part >= 0) density += alpha * ty_guide_segments_pdf(&s, part, event->t);
    for (int c = 0; c < 3; ++c) path->beta[c] = density > 0.0f ? scattered[c] / density : 0.0f;
    return true;
}

#endif
