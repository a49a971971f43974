/* Lobes of light about a direction. */
#ifndef TY_METHOD_POP_LOBE_K_H
#define TY_METHOD_POP_LOBE_K_H

#include "direct/beam.k.h"
#include "direct/forward.k.h"

/* 1 / sqrt(x) to 5e-6 for normal x > 0, without what takes processors long: two of Newton's steps. */
TY_FN float ty_pop_root_inverse(float x) {
    const float half = 0.5f * x;
    float y = ty_float_from_bits(0x5f375a86u - (ty_bits_from_float(x) >> 1));
    y *= 1.5f - half * y * y;
    return y * (1.5f - half * y * y);
}

/* The phase function as ty_hg, to 2e-5; lines are seen as lobes of 0.9999. tilt: 2 (1 - mu). */
TY_FN float ty_pop_hg_tilted(float tilt, float cosine) {
    const float g = ty_clampf(cosine, -0.9999f, 0.9999f), less = 1.0f - g;
    const float y = ty_pop_root_inverse(less * less + g * tilt);
    return TY_INV_4PI * (1.0f + g) * less * y * y * y;
}

TY_FN float ty_pop_hg(float mu, float cosine) {
    return ty_pop_hg_tilted(2.0f * (1.0f - mu), cosine);
}

/* Scattering of mean cosine g spreads light that comes evenly from a disc of the sky, of mean cosine `disc`, into what
 * a lobe stands for. Where discs are small beside lobes, that of mean cosine disc g is best, since neighbours add up.
 * Where they are large it is far brighter in the middle than they are, and a lobe is taken that is as bright: HG's part
 * within the disc, (1 + g) / (2 g) (1 - (1 - g) / s) with s^2 = (1 - g)^2 + 4 g (1 - disc), over the disc. It goes from
 * one to the other as s^2 grows over (1 - g)^2. Returns the lobe's mean cosine. */
TY_FN float ty_pop_disc_lobe(float g, float disc) {
    const float a = ty_minf(fabsf(g), 0.9999f), less = 1.0f - a, least = less * less;
    const float wider = 4.0f * a * ty_maxf(0.0f, 1.0f - disc), s = sqrtf(least + wider);
    const float sum = s + less, part = 1.0f / (s * s * sum), peak = 2.0f * (1.0f + a) * s * part;
    const float bright = 1.0f - 4.0f / (1.0f + sqrtf(1.0f + 8.0f * peak)), mean = disc * a;
    const float share = wider * sum * part, found = mean + share * share * (bright - mean);
    return g < 0.0f ? -found : found;
}

/* The same for ty_forward_lobe: of light that has scattered, over that light's own mean cosine. */
TY_FN float ty_pop_disc_spread(float u, float r, float s, float g, float disc) {
    const float b = ty_maxf(ty_forward_cosine(u, r, s), 1e-3f);
    return ty_pop_disc_lobe(b * g, disc) / b;
}

/* What fraction of a lobe goes to the cells in front, to each of the four beside and behind (Eq. 2 and 3), to 2e-6:
 * half the sum of front and back is even in a, half their difference odd, and both are so smooth that polynomials of
 * a^2 (interpolated at Chebyshev's points of [0, 1]) take half the time of the formula. They partition the sphere. */
TY_FN void ty_pop_patches(float a, float* front, float* side, float* back) {
    const float t = a * a;
    float sum = 5.95936914e-2f, difference = 5.23741381e-2f;
    sum = sum * t - 2.59721707e-1f;
    difference = difference * t - 1.79535955e-1f;
    sum = sum * t + 4.02785332e-1f;
    difference = difference * t + 1.56512778e-1f;
    sum = sum * t - 1.52046578e-1f;
    difference = difference * t + 1.32428145e-1f;
    sum = sum * t - 2.37033835e-1f;
    difference = difference * t - 2.38015536e-1f;
    sum = sum * t + 9.79742924e-2f;
    difference = difference * t - 1.26779953e-1f;
    sum = sum * t + 4.42003242e-1f;
    difference = difference * t + 3.28016701e-1f;
    sum = sum * t + 1.46446141e-1f;
    difference = difference * t + 3.75000857e-1f;
    const float beside = ty_maxf(0.0f, 1.0f - 2.0f * sum);
    *back = ty_maxf(0.0f, sum - a * difference);
    *side = 0.25f * beside;
    *front = 1.0f - beside - *back;
}

#endif
