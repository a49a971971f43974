/* Equiangular sampling (Kulla and Fajardo 2012) of light that a nearby local light scatters into a ray: density in
 * proportion to 1/d^2. It is combined by multiple importance sampling with delta-tracking collisions; its weight for a
 * path is
 * w = 1 / (1 + (d / r)^4) * l / (l + p), d: distance from the scattering point to the light's point, m; r: the light's
 * reach, m; l: solid-angle density of light sampling, 1/sr; p: phase function in its direction, 1/sr.
 * Any w known to both techniques is unbiased. This one removes the 1/d^2 near a light, whose variance in a medium is
 * infinite, from the collision estimate, leaves lights larger than the phase function's peak to phase-function
 * sampling, and adds no cost for rays far from local lights. */
#ifndef TY_METHOD_PATH_TRACE_EQUIANGULAR_K_H
#define TY_METHOD_PATH_TRACE_EQUIANGULAR_K_H

#include "method/path/trace/collision.k.h"
#include "method/path/trace/kernel.h"

/* Interval of a ray that covers all media, m. */
typedef struct ty_media_interval {
    float enter, leave;
} ty_media_interval;

TY_FN ty_media_interval ty_spans_interval(const ty_spans* spans) {
    ty_media_interval interval = {TY_FLOAT_MAX, 0.0f};
    for (int32_t i = 0; i < spans->count; ++i) {
        interval.enter = ty_minf(interval.enter, spans->enter[i]);
        interval.leave = ty_maxf(interval.leave, spans->leave[i]);
    }
    return interval;
}

/* Closest approach of a ray to a point. */
typedef struct ty_closest_approach {
    float t;         /* m along the ray from its origin */
    float distance2; /* squared distance of the ray's line and the point, m^2, with a lower bound */
    float radius2;   /* squared distance of the ray's origin and the point, m^2 */
} ty_closest_approach;

/* reach2: of the light. */
TY_FN ty_closest_approach ty_closest_approach_find(ty_vec origin, ty_vec direction, ty_vec point, float reach2) {
    const ty_vec to = ty_sub(point, origin);
    const float t = ty_dot(to, direction);
    const ty_vec off = ty_mad(to, direction, -t);
    return (ty_closest_approach){t, ty_dot(off, off) + 1e-10f * reach2, ty_dot(to, to)};
}

/* First factor of w at squared distance d2 from a light with squared reach r2, and its complement without
 * cancellation, which cancels 1/d^2 near the light. */
TY_FN float ty_mis_near_weight(float d2, float r2) {
    const float x = d2 / r2;
    return 1.0f / (1.0f + x * x);
}

TY_FN float ty_mis_far_weight(float d2, float r2) {
    const float x = d2 / r2;
    return x * x / (1.0f + x * x);
}

/* Second factor of w. Lights without extent have density 0 and cannot be hit by sampled directions. */
TY_FN float ty_mis_small_light_weight(float density, float phase) {
    return density > 0.0f ? density / (density + phase) : 1.0f;
}

/* 1 - w. */
TY_FN float ty_mis_weight_collision(float d2, float r2, float density, float phase) {
    return ty_mis_far_weight(d2, r2) + ty_mis_near_weight(d2, r2) * (1.0f - ty_mis_small_light_weight(density, phase));
}

/* Density, 1/m, of ty_equiangular_sample(): angle: between the ends of the interval, rad; beyond: t - closest, m. */
TY_FN float ty_equiangular_density(float angle, float distance, float beyond) {
    return distance / (ty_maxf(angle, 1e-7f) * (distance * distance + beyond * beyond));
}

/* Samples t in an interval in proportion to the angle subtended at a point beside the ray; `closest`: t of the ray's
 * closest point to it; `distance`: between the two. Returns the density of *t, 1/m. */
TY_FN float ty_equiangular_sample(ty_media_interval interval, float closest, float distance, float u, float* t) {
    const float from = atanf((interval.enter - closest) / distance), to = atanf((interval.leave - closest) / distance);
    *t = ty_clampf(closest + distance * tanf(ty_lerpf(from, to, u)), interval.enter, interval.leave);
    return ty_equiangular_density(to - from, distance, *t - closest);
}

#endif
