/* Henyey-Greenstein lobes of light about a direction, flattened for disc sources, and patch fractions of a lobe. */
#ifndef TY_METHOD_POP_GRID_LOBE_K_H
#define TY_METHOD_POP_GRID_LOBE_K_H

#include "direct/media/attenuation.k.h"
#include "direct/single/forward.k.h"

/* Clamps g to +-0.9999. Floats of one sign have the order of their bits, and integer minima compile to single
 * instructions where float ones become compares and masks. */
TY_FN float ty_pop_clamped_cosine(float cosine) {
    const int32_t max_bits = 0x3f7ff972, bits = (int32_t)ty_bits_from_float(cosine);
    const uint32_t min_bits = 0xbf7ff972u, below = (uint32_t)(bits < max_bits ? bits : max_bits);
    return ty_float_from_bits(below < min_bits ? below : min_bits);
}

/* Henyey-Greenstein phase function by ty_hg_approximate, from 2 (1 - mu), with g clamped to +-0.9999. */
TY_FN float ty_pop_hg_fast(float two_one_minus_mu, float cosine) {
    return ty_hg_approximate(two_one_minus_mu, ty_pop_clamped_cosine(cosine));
}

TY_FN float ty_pop_hg(float mu, float cosine) {
    return ty_pop_hg_fast(2.0f * (1.0f - mu), cosine);
}

/* Light from a disc of the sky, of mean cosine `disc`, is less peaked after scattering than a lobe about the disc's
 * center, but equal to it far from the axis. Lobes are therefore flattened about their axis: under a tent in 1 - mu,
 * with weight max(0, 1 - (1 - mu) / width), the radiance is replaced by its mean, which conserves energy. A delta
 * lobe gets mean cosine 1 - width / 3, which this width makes the disc's. HG of mean cosine x loses 2 x (1 + x)
 * width^3 / (3 (1 - x + s)^4) of its mean cosine, where s^2 = (1 - x)^2 + 2 x width; the rest of the disc's blur
 * comes from a smaller g. Lobes of negative g are flattened about their own axis. */
TY_FN float ty_pop_disc_width(float disc) {
    return ty_clampf(3.0f * (1.0f - disc), 1e-12f, 2.0f);
}

TY_FN float ty_pop_disc_tent_weight(float mu, float width) {
    return ty_maxf(0.0f, 1.0f - (1.0f - mu) / width);
}

TY_FN float ty_pop_disc_root(float x, float width) {
    const float square = (1.0f - x) * (1.0f - x) + 2.0f * x * width;
    return square * ty_inverse_sqrt(square);
}

/* Ratio of the flattened HG(x)'s mean cosine to x, as numerator (returned) and denominator (*whole). */
TY_FN float ty_pop_disc_flattened_cosine(float x, float width, float* whole) {
    const float sum = 1.0f - x + ty_pop_disc_root(x, width), square = sum * sum;
    *whole = square * square;
    return *whole - (2.0f / 3.0f) * (1.0f + x) * width * width * width;
}

/* Mean cosine g of a lobe that equals a times the disc's mean cosine after the flattening of HG(x). */
TY_FN float ty_pop_disc_matched_g(float a, float disc, float x, float width) {
    float whole;
    const float left = ty_pop_disc_flattened_cosine(x, width, &whole);
    return ty_minf(a * disc * whole / left, a);
}

/* Mean cosine of the HG that has, flattened, mean cosine a times the disc's, for a >= 0 (fixed-point iteration). */
TY_FN float ty_pop_disc_lobe(float a, float disc, float width) {
    float x = a;
    for (int n = 0; n < 4; ++n) x = ty_pop_disc_matched_g(a, disc, x, width);
    return x;
}

/* Mean of HG(x) under the tent, 1/sr. */
TY_FN float ty_pop_disc_mean(float x, float width) {
    const float sum = 1.0f - x + ty_pop_disc_root(x, width);
    return 4.0f * TY_INV_4PI * (1.0f + x) / (sum * sum);
}

/* (4 pi ty_pop_disc_mean(x) - 1) / x, with its limit at x = 0. */
TY_FN float ty_pop_disc_slope(float x, float width) {
    const float one = 1.0f + ty_pop_disc_root(x, width), q = x - 2.0f + 2.0f * width - one;
    const float sum = 2.0f * one + x * q; /* numerator and denominator are scaled by `one`, which saves divisions */
    return (4.0f * one * (one - q) - x * q * q) / (sum * sum);
}

/* Single scattering of a disc's light, 1/sr, for view directions outside the tent. lobe: ty_pop_disc_lobe of |g|. */
TY_FN float ty_pop_disc_single_far(float mu, float g, float lobe) {
    return ty_pop_hg(g < 0.0f ? -mu : mu, lobe);
}

/* The same for any view direction. mean: ty_pop_disc_mean of the lobe. */
TY_FN float ty_pop_disc_single(float mu, float g, float width, float lobe, float mean) {
    const float fraction = ty_pop_disc_tent_weight(g < 0.0f ? -mu : mu, width);
    /* A weighted sum, since near-delta lobes are too bright for differences. */
    return (1.0f - fraction) * ty_pop_disc_single_far(mu, g, lobe) + fraction * mean;
}

/* g of the next scattering's lobe for forward-scattered light of mean cosine b. */
TY_FN float ty_pop_disc_forward_g(float b, float g, float disc, float width, float lobe) {
    return ty_pop_disc_matched_g(fabsf(g), disc, b * lobe, width);
}

/* Scattering towards the eye of a disc's forward-scattered light, as ty_forward_lobe, outside the tent. */
TY_FN float ty_pop_disc_forward_far(float mu, float u, float r, float s, float g, float disc, float width, float lobe) {
    const float b = ty_forward_lobe_cosine(u, r, s), spread = ty_pop_disc_forward_g(b, g, disc, width, lobe);
    const float slope = ty_hg_slope(g < 0.0f ? -mu : mu, b * spread);
    return ty_maxf(0.0f, r - u) * TY_INV_4PI * (1.0f + spread * slope);
}

/* The same for any view direction, flattened. */
TY_FN float ty_pop_disc_forward(float mu, float u, float r, float s, float g, float disc, float width, float lobe) {
    const float along = g < 0.0f ? -mu : mu, b = ty_forward_lobe_cosine(u, r, s);
    const float spread = ty_pop_disc_forward_g(b, g, disc, width, lobe), x = b * spread;
    const float fraction = ty_pop_disc_tent_weight(along, width);
    const float slope = (1.0f - fraction) * ty_hg_slope(along, x) + fraction * ty_pop_disc_slope(x, width);
    return ty_maxf(0.0f, r - u) * TY_INV_4PI * (1.0f + spread * slope);
}

/* Eq. 2 and 3 (Elek 2014): fractions of an HG lobe in the solid-angle patches of the cell in front, each of the four
 * beside and the one behind, to 2e-6. Half the sum of front and back is even in a, half their difference odd; both
 * are smooth, so polynomials in a^2 (interpolated at Chebyshev points of [0, 1]) take half the time of the formula.
 * The six fractions sum to 1. */
TY_FN void ty_pop_patch_fractions(float a, float* front, float* side, float* back) {
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
