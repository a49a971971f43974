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

/* Lines are seen as lobes of +-0.9999. Floats of one sign are in the order of their bits, and of whole numbers
 * compilers have minima where of floats they make choices and masks. */
TY_FN float ty_pop_seen_cosine(float cosine) {
    const int32_t most = 0x3f7ff972, bits = (int32_t)ty_bits_from_float(cosine);
    const uint32_t least = 0xbf7ff972u, below = (uint32_t)(bits < most ? bits : most);
    return ty_float_from_bits(below < least ? below : least);
}

/* The phase function as ty_hg, to 2e-5. tilt: 2 (1 - mu). */
TY_FN float ty_pop_hg_tilted(float tilt, float cosine) {
    const float g = ty_pop_seen_cosine(cosine), less = 1.0f - g;
    const float y = ty_pop_root_inverse(less * less + g * tilt);
    return TY_INV_4PI * (1.0f + g) * less * y * y * y;
}

TY_FN float ty_pop_hg(float mu, float cosine) {
    return ty_pop_hg_tilted(2.0f * (1.0f - mu), cosine);
}

/* Light from a disc of the sky, of mean cosine `disc`, is less peaked after scattering than a lobe about the disc's
 * middle, but far from it alike. So lobes are flattened about their axis: what is under a tent of 1 - mu, share
 * max(0, 1 - (1 - mu) / width), gets its own mean, and nothing is lost. Of a line that leaves the tent, of mean cosine
 * 1 - width / 3: this width makes it the disc's. Of HG of mean cosine x it takes
 * 2 x (1 + x) width^3 / (3 (1 - x + s)^4), s^2 = (1 - x)^2 + 2 x width, from the mean cosine. What is missing of the
 * disc's share, wider lobes take. Those of negative g are flattened about their own axis. */
TY_FN float ty_pop_disc_width(float disc) {
    return ty_clampf(3.0f * (1.0f - disc), 1e-12f, 2.0f);
}

TY_FN float ty_pop_disc_share(float mu, float width) {
    return ty_maxf(0.0f, 1.0f - (1.0f - mu) / width);
}

TY_FN float ty_pop_disc_root(float x, float width) {
    const float square = (1.0f - x) * (1.0f - x) + 2.0f * x * width;
    return square * ty_pop_root_inverse(square);
}

/* What HG(x) that is flattened has of its mean cosine, in parts: the first over the second. */
TY_FN float ty_pop_disc_left(float x, float width, float* whole) {
    const float sum = 1.0f - x + ty_pop_disc_root(x, width), square = sum * sum;
    *whole = square * square;
    return *whole - (2.0f / 3.0f) * (1.0f + x) * width * width * width;
}

/* What the mean cosine of a lobe must be so that it has that of HG(a) times the disc's where it is flattened as HG(x)
 * is. */
TY_FN float ty_pop_disc_spread(float a, float disc, float x, float width) {
    float whole;
    const float left = ty_pop_disc_left(x, width, &whole);
    return ty_minf(a * disc * whole / left, a);
}

/* The mean cosine of the HG that, flattened, has that of HG(a) times the disc's, for a >= 0. */
TY_FN float ty_pop_disc_lobe(float a, float disc, float width) {
    float x = a;
    for (int n = 0; n < 4; ++n) x = ty_pop_disc_spread(a, disc, x, width);
    return x;
}

/* The mean of HG(x) under the tent. */
TY_FN float ty_pop_disc_mean(float x, float width) {
    const float sum = 1.0f - x + ty_pop_disc_root(x, width);
    return 4.0f * TY_INV_4PI * (1.0f + x) / (sum * sum);
}

/* (4 pi ty_pop_disc_mean(x) - 1) / x, also where x is 0. */
TY_FN float ty_pop_disc_slope(float x, float width) {
    const float one = 1.0f + ty_pop_disc_root(x, width), q = x - 2.0f + 2.0f * width - one;
    const float sum = 2.0f * one + x * q; /* all as they are without divisions by `one` */
    return (4.0f * one * (one - q) - x * q * q) / (sum * sum);
}

/* What of a disc's light scatters once, seen from beyond the tent. lobe: ty_pop_disc_lobe of |g|. */
TY_FN float ty_pop_disc_once_far(float mu, float g, float lobe) {
    return ty_pop_hg(g < 0.0f ? -mu : mu, lobe);
}

/* And from anywhere; mean: its ty_pop_disc_mean. */
TY_FN float ty_pop_disc_once(float mu, float g, float width, float lobe, float mean) {
    const float share = ty_pop_disc_share(g < 0.0f ? -mu : mu, width);
    /* Lines are too bright for differences. */
    return (1.0f - share) * ty_pop_disc_once_far(mu, g, lobe) + share * mean;
}

/* The mean cosine of a lobe about light that has scattered and kept its direction, of mean cosine b. */
TY_FN float ty_pop_disc_again(float b, float g, float disc, float width, float lobe) {
    return ty_pop_disc_spread(fabsf(g), disc, b * lobe, width);
}

/* What of its light that has scattered and kept its direction does so once more: ty_forward_lobe, seen from beyond the
 * tent. */
TY_FN float ty_pop_disc_forward_far(float mu, float u, float r, float s, float g, float disc, float width, float lobe) {
    const float b = ty_forward_cosine(u, r, s), spread = ty_pop_disc_again(b, g, disc, width, lobe);
    const float slope = ty_hg_slope(g < 0.0f ? -mu : mu, b * spread);
    return ty_maxf(0.0f, r - u) * TY_INV_4PI * (1.0f + spread * slope);
}

/* And from anywhere: flattened. */
TY_FN float ty_pop_disc_forward(float mu, float u, float r, float s, float g, float disc, float width, float lobe) {
    const float along = g < 0.0f ? -mu : mu, b = ty_forward_cosine(u, r, s);
    const float spread = ty_pop_disc_again(b, g, disc, width, lobe), x = b * spread;
    const float share = ty_pop_disc_share(along, width);
    const float slope = (1.0f - share) * ty_hg_slope(along, x) + share * ty_pop_disc_slope(x, width);
    return ty_maxf(0.0f, r - u) * TY_INV_4PI * (1.0f + spread * slope);
}

/* Fractions of a lobe for the cells in front, each of the four beside and behind, Eq. 2 and 3 (Elek 2014), to 2e-6:
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
