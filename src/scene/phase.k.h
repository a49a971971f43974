/* Henyey-Greenstein phase function (Henyey and Greenstein 1941). */
#ifndef TY_SCENE_PHASE_K_H
#define TY_SCENE_PHASE_K_H

#include "base/vector.k.h"

#define TY_INV_4PI 0.0795774715459476679f

/* p(mu, g) per steradian; mu: cosine between the directions of propagation before and after. */
TY_FN float ty_hg(float mu, float g) {
    /* 1 + g^2 - 2 g mu, in a form without cancellation for g and mu near 1. */
    const float base = (1.0f - g) * (1.0f - g) + 2.0f * g * (1.0f - mu);
    return TY_INV_4PI * (1.0f - g * g) / (base * sqrtf(base));
}

/* Inverse CDF of the cosine, u in [0, 1). */
TY_FN float ty_hg_sample_cosine(float g, float u) {
    if (g > -1e-3f && g < 1e-3f) return 1.0f - 2.0f * u;
    const float s = (1.0f - g * g) / (1.0f + g - 2.0f * g * u);
    return ty_clampf((1.0f + g * g - s * s) / (2.0f * g), -1.0f, 1.0f);
}

TY_FN ty_vec ty_hg_sample(ty_vec axis, float g, float u, float v) {
    return ty_direction_about(axis, ty_hg_sample_cosine(g, u), v);
}

#endif
