/* Lobes of light about a direction. */
#ifndef TY_METHOD_POP_LOBE_K_H
#define TY_METHOD_POP_LOBE_K_H

#include "direct/beam.k.h"
#include "scene/phase.k.h"

/* 1 / sqrt(x) to 5e-6 for normal x > 0, without what takes processors long: two of Newton's steps. */
TY_FN float ty_pop_root_inverse(float x) {
    const float half = 0.5f * x;
    float y = ty_float_from_bits(0x5f375a86u - (ty_bits_from_float(x) >> 1));
    y *= 1.5f - half * y * y;
    return y * (1.5f - half * y * y);
}

/* The phase function as ty_hg, to 2e-5; lines are seen as lobes of 0.9999. */
TY_FN float ty_pop_hg(float mu, float cosine) {
    const float g = ty_clampf(cosine, -0.9999f, 0.9999f);
    const float base = (1.0f - g) * (1.0f - g) + 2.0f * g * (1.0f - mu);
    const float y = ty_pop_root_inverse(base);
    return TY_INV_4PI * (1.0f - g * g) * y * y * y;
}

/* (4 pi HG(x) - 1) / x, which is 3 mu at x = 0. */
TY_FN float ty_pop_hg_slope(float mu, float x) {
    const float base = ty_maxf((1.0f - x) * (1.0f - x) + 2.0f * x * (1.0f - mu), 1e-10f);
    const float u = sqrtf(base), cube = base * u;
    return ((2.0f * mu - x) * (1.0f + u + base) / (1.0f + u) - x) / cube;
}

/* The mean cosine of light that has scattered and kept its direction (grid.h): u, r, s are U, R, S. */
TY_FN float ty_pop_lobe_cosine(float u, float r, float s) {
    return ty_clampf((s - u) / ty_maxf(r - u, 1e-20f), 0.0f, 1.0f);
}

/* Its radiance at cosine mu about the direction, scattered once more by `spread` (a phase function's mean cosine, or of
 * the light that comes in, or their product). Its moments are right; far from the direction it may be a little below 0,
 * which the diffusion's light makes up for. */
TY_FN float ty_pop_lobe_forward(float mu, float u, float r, float s, float spread) {
    const float x = ty_pop_lobe_cosine(u, r, s) * spread;
    return (r - u) * TY_INV_4PI * (1.0f + spread * ty_pop_hg_slope(mu, x));
}

/* What fraction of a lobe goes to the cells in front, to each of the four beside and behind (Eq. 2 and 3). Below the
 * cosine mu there is (1 - a) (1 + mu) / (w (1 + a + w)) of HG(a), w^2 = 1 + a^2 - 2 a mu: 2 pi F without its 0 / 0. */
TY_FN void ty_pop_patches(float a, float* front, float* side, float* back) {
    const float c = 0.70710678f, square = 1.0f + a * a, tilt = 2.0f * c * a;
    const float y1 = ty_pop_root_inverse(square - tilt), y2 = ty_pop_root_inverse(square + tilt);
    const float d1 = 1.0f + (1.0f + a) * y1, d2 = 1.0f + (1.0f + a) * y2;
    const float scale = (1.0f - a) / (d1 * d2);
    const float not_front = scale * (1.0f + c) * y1 * y1 * d2;
    *back = scale * (1.0f - c) * y2 * y2 * d1;
    *front = 1.0f - not_front;
    *side = 0.25f * (not_front - *back);
}

#endif
