/* Lamps (point and spot lights) in media: distances along a ray and directions of a vertex, both sampled for the light
 * that the lamp sends into a ray by one scattering.
 *
 * A ray leaves a vertex at distance r from a lamp and at angle theta from it, and passes the lamp at distance
 * D = r sin(theta). From a point of the ray, light is scattered by phi, the angle between the ray and the direction to
 * the lamp, and with D dt = d^2 dphi the ray receives
 * E = I / D integral of sigma_s p(cos phi) T dphi, phi = theta .. pi
 * (Kulla and Fajardo 2012). Directions sampled by the phase function or the BRDF leave 1/D in the estimate, whose
 * square has no finite mean, and phi uniform leaves the peak of p. Both angles are sampled by
 * c(phi, g) = (1 - g^2) / (pi (1 + g^2 - 2 g cos phi)), phi = 0 .. pi (the wrapped Cauchy distribution),
 * which has a closed inverse and the tails that p and its integral have for Henyey-Greenstein scattering (own
 * derivation; Georgiev et al. 2013 sample the two directions jointly). */
#ifndef TY_METHOD_PATH_TRACE_POINT_LIGHT_DIRECTION_K_H
#define TY_METHOD_PATH_TRACE_POINT_LIGHT_DIRECTION_K_H

#include "method/path/trace/equiangular.k.h"

/* Bound of distances along rays, m: squares of it, and their products with other distances, are finite. */
#define TY_POINT_LIGHT_FAR 1e12f

/* c(phi, g); tilt: 1 - cos(phi). */
TY_FN float ty_wrapped_cauchy(float tilt, float g) {
    return (1.0f - g * g) / (TY_PI * ((1.0f - g) * (1.0f - g) + 2.0f * g * tilt));
}

/* 1 - cos(phi) of a point at `before` along the ray from its closest approach, negative past it; d: distance of the
 * point. */
TY_FN float ty_point_light_tilt(float distance2, float before, float d) {
    return before > 0.0f ? distance2 / (d * (d + before)) : 1.0f - before / d;
}

/* tan(phi / 2) */
TY_FN float ty_point_light_half_tangent(float distance, float before) {
    const float d = sqrtf(distance * distance + before * before);
    return before > 0.0f ? distance / (d + before) : (d - before) / distance;
}

/* The g nearest to 0 of the media on a ray; 0 if one of them varies. */
TY_FN float ty_spans_broadest_g(TY_GLOBAL const ty_medium_view* media, const ty_spans* spans) {
    float g = media[spans->medium[0]].g[1];
    for (int32_t i = 0; i < spans->count; ++i) {
        TY_GLOBAL const ty_medium_view* medium = &media[spans->medium[i]];
        if (medium->has_g_field != 0) return 0.0f;
        if (fabsf(medium->g[1]) < fabsf(g)) g = medium->g[1];
    }
    return ty_clampf(g, -0.98f, 0.98f);
}

/* Angles phi of an interval of a ray, of the distribution c(phi, g) in x = (1 + g) / (1 - g) tan(phi / 2), whose
 * cumulative distribution is an arc tangent. */
typedef struct ty_point_light_arc {
    float from, to; /* x at both ends */
    float range;    /* atan(to) - atan(from) */
} ty_point_light_arc;

TY_FN ty_point_light_arc ty_point_light_arc_make(float half_tangent_from, float half_tangent_to, float g) {
    const float stretch = (1.0f + g) / (1.0f - g);
    const float from = stretch * half_tangent_from, to = stretch * half_tangent_to;
    return (ty_point_light_arc){from, to, ty_maxf(atan2f(to - from, 1.0f + from * to), 1e-30f)};
}

/* x at the fraction u of the arc. */
TY_FN float ty_point_light_arc_sample(const ty_point_light_arc* arc, float u) {
    float x;
    if (arc->from < 1.0f) {
        x = tanf(atanf(arc->from) + u * arc->range);
    } else {
        const float part = tanf(u * arc->range);
        x = (arc->from + part) / (1.0f - arc->from * part);
    }
    if (x >= arc->from && x <= arc->to) return x;
    return x >= arc->from || x < 0.0f ? arc->to : arc->from;
}

/* Samples t in an interval: in proportion to c(phi, g), for the peak of p, but for the fraction `uniform` of the
 * samples with phi uniform, for lights of which only a part of the ray receives any (the cone of a spot light); 1:
 * equiangular sampling. Returns the density of *t by both, 1/m. */
TY_FN float ty_point_light_distance_sample(ty_media_interval interval, const ty_closest_approach* closest, float g,
                                           float uniform, float u, float* t) {
    const float distance = sqrtf(closest->distance2), leave = ty_minf(interval.leave, TY_POINT_LIGHT_FAR);
    const float from = ty_point_light_half_tangent(distance, closest->t - interval.enter);
    const float to = ty_point_light_half_tangent(distance, closest->t - leave);
    const ty_point_light_arc even = ty_point_light_arc_make(from, to, 0.0f),
                             peaked = ty_point_light_arc_make(from, to, g);
    const float x =
        u < uniform ? ty_point_light_arc_sample(&even, u / uniform)
                    : ty_point_light_arc_sample(&peaked, (u - uniform) / (1.0f - uniform)) * (1.0f - g) / (1.0f + g);
    *t = ty_clampf(closest->t - 0.5f * distance * (1.0f / x - x), interval.enter, leave);
    const float before = closest->t - *t, d2 = closest->distance2 + before * before;
    const float angle_pdf = ty_wrapped_cauchy(ty_point_light_tilt(closest->distance2, before, sqrtf(d2)), g);
    return 0.5f * (uniform / even.range + (1.0f - uniform) * TY_PI * angle_pdf / peaked.range) * distance / d2;
}

/* Number of lamp directions, at most 1, of a vertex at closest->radius2 from a lamp. rate: that beside the lamp. */
TY_FN float ty_point_light_direction_rate(const ty_path_request* request, float rate,
                                          const ty_closest_approach* closest) {
    return rate / (1.0f + closest->radius2 / request->point_light_reach2);
}

/* Samples a direction at the angle theta from that from `origin` to `lamp` with density c(theta, g); u, turn in
 * [0, 1). */
TY_FN ty_vec ty_point_light_direction_sample(ty_vec origin, ty_vec point_light, float g, float u, float turn) {
    const ty_vec to = ty_sub(point_light, origin);
    const float d2 = ty_dot(to, to);
    const ty_vec axis = d2 > 1e-30f ? ty_scale(to, 1.0f / sqrtf(d2)) : ty_vec_make(0, 0, 1);
    const float half_tangent = ty_minf((1.0f - g) / (1.0f + g) * tanf(0.5f * TY_PI * u), 1e9f);
    /* Along the axis and across: sine and cosine from the tangent of the half angle. */
    const float across = 2.0f / (1.0f / ty_maxf(half_tangent, 1e-30f) + half_tangent);
    const float along = (1.0f - half_tangent * half_tangent) / (1.0f + half_tangent * half_tangent);
    float sine, cosine;
    ty_vec s, t;
    ty_onb(axis, &s, &t);
    ty_sincos_2pi(turn, &sine, &cosine);
    return ty_mad(ty_mad(ty_scale(axis, along), s, across * cosine), t, across * sine);
}

/* The density of ty_point_light_direction_sample for a ray, 1/sr. */
TY_FN float ty_point_light_direction_pdf(const ty_closest_approach* closest, float g) {
    const float r = sqrtf(closest->radius2), tilt = ty_point_light_tilt(closest->distance2, closest->t, r);
    return ty_wrapped_cauchy(tilt, g) * r / (2.0f * TY_PI * sqrtf(closest->distance2));
}

#endif
