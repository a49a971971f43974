/* Equi-angular sampling (Kulla and Fajardo 2012): light that a nearby lamp scatters into a ray, sampled where the lamp
 * is near the ray. It is a second technique beside the collisions of the free flight, and the two share each light path
 * by how far from the lamp it scatters:
 *     w = 1 / (1 + (d / r)^4) * l / (l + p),  d: from the scattering point to the lamp's point,  r: the lamp's reach,
 * l: density per steradian with which the lamp's point is sampled, p: the phase function towards it.
 * Any w that both sides know gives a mean without bias; this one takes the 1/d^2 near a lamp, whose variance in a
 * medium is not finite, away from collisions, leaves lamps that look larger than the phase function's peak to
 * directions sampled from it, and costs rays that pass far from lamps nothing. */
#ifndef TY_PATH_EQUIANGULAR_K_H
#define TY_PATH_EQUIANGULAR_K_H

#include "method/path/collision.k.h"
#include "method/path/kernel.h"

/* The part of a ray that is in media. */
typedef struct ty_media_interval {
    float enter, leave;
} ty_media_interval;

TY_FN ty_media_interval ty_spans_interval(const ty_spans* spans) {
    ty_media_interval stretch = {TY_FLOAT_MAX, 0.0f};
    for (int32_t i = 0; i < spans->count; ++i) {
        stretch.enter = ty_minf(stretch.enter, spans->enter[i]);
        stretch.leave = ty_maxf(stretch.leave, spans->leave[i]);
    }
    return stretch;
}

/* The first factor of w at squared distance d2 from a lamp with squared reach r2, and what is left of 1, without
 * cancellation: it takes 1/d^2 away near the lamp. */
TY_FN float ty_mis_near_weight(float d2, float r2) {
    const float x = d2 / r2;
    return 1.0f / (1.0f + x * x);
}

TY_FN float ty_mis_far_weight(float d2, float r2) {
    const float x = d2 / r2;
    return x * x / (1.0f + x * x);
}

/* The second factor; lamps without extent have density 0, and are never met by chance. */
TY_FN float ty_mis_small_light_weight(float density, float phase) {
    return density > 0.0f ? density / (density + phase) : 1.0f;
}

/* 1 - w. */
TY_FN float ty_mis_weight_collision(float d2, float r2, float density, float phase) {
    return ty_mis_far_weight(d2, r2) + ty_mis_near_weight(d2, r2) * (1.0f - ty_mis_small_light_weight(density, phase));
}

/* Samples a stretch in proportion to the angle under which a point at `nearest` along the ray and `off` beside it sees
 * its parts; returns the density of *t. */
TY_FN float ty_equiangular_sample(ty_media_interval stretch, float nearest, float off, float u, float* t) {
    const float from = atanf((stretch.enter - nearest) / off), to = atanf((stretch.leave - nearest) / off);
    *t = ty_clampf(nearest + off * tanf(ty_lerpf(from, to, u)), stretch.enter, stretch.leave);
    const float beyond = *t - nearest;
    return off / (ty_maxf(to - from, 1e-7f) * (off * off + beyond * beyond));
}

#endif
