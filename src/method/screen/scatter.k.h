/* Scattering pyramid: the fraction of light that stays at a level, the fraction passed to the next, and the filters
 * between levels.
 *
 * A texel holds, per channel, light E and its moment Q = E times a measure of spread: the variance of its Gaussian, Eq.
 * 2 (Elek 2013), or the optical thickness it was scattered over. Both are linear, so filtering keeps Q / E the
 * light-weighted mean. Descending one level and ascending again adds a known variance; light whose variance lies
 * between those of two levels is divided between them such that the variance of the sum is right. */
#ifndef TY_METHOD_SCREEN_SCATTER_K_H
#define TY_METHOD_SCREEN_SCATTER_K_H

#include "method/screen/split.k.h"

/* Polynomial fractions: terms in z = 2 t / T_MAX - 1, t = tau / (tau + SCALE), clamped to T_MAX (tau = 76). */
#define TY_SCREEN_FRACTION_TERMS 8
#define TY_SCREEN_FRACTION_SCALE 4.0f
#define TY_SCREEN_FRACTION_T_MAX 0.95f

/* Fraction of a level's light passed to the next level, as a function of its measure of spread. */
typedef struct ty_screen_down_fraction {
    int32_t small_angle;
    float low, inverse_range;              /* variance: of the level, and 1 / (increase to the next level) */
    float terms[TY_SCREEN_FRACTION_TERMS]; /* small angle: polynomial coefficients, constant first */
} ty_screen_down_fraction;

TY_FN float ty_screen_down_fraction_at(ty_screen_down_fraction fraction, float measure) {
    if (!fraction.small_angle) return ty_clampf((measure - fraction.low) * fraction.inverse_range, 0.0f, 1.0f);
    const float t = ty_minf(measure / (measure + TY_SCREEN_FRACTION_SCALE), TY_SCREEN_FRACTION_T_MAX);
    const float z = t * (2.0f / TY_SCREEN_FRACTION_T_MAX) - 1.0f;
    float sum = fraction.terms[TY_SCREEN_FRACTION_TERMS - 1];
    for (int32_t i = TY_SCREEN_FRACTION_TERMS - 2; i >= 0; --i) sum = sum * z + fraction.terms[i];
    return ty_clampf(sum, 0.0f, 1.0f);
}

/* The mean measure of a texel's light; 0 without light. */
TY_FN float ty_screen_mean_measure(float light, float moment) {
    return moment / (light + 1e-30f);
}

/* The fraction of a texel's light that is passed on. */
TY_FN float ty_screen_passed_fraction(ty_screen_down_fraction fraction, float light, float moment) {
    return ty_screen_down_fraction_at(fraction, ty_screen_mean_measure(light, moment));
}

/* Transport of one channel per unit radiance: the part passed to level 1, the part that stays, and the airlight. */
typedef struct ty_screen_transport {
    float passed, stays, airlight;
} ty_screen_transport;

TY_FN ty_screen_transport ty_screen_transport_at(float sigma_s, float sigma_a, float airlight, float forward,
                                                 ty_screen_down_fraction down_fraction, float distance, float measure) {
    const ty_screen_light_split light = ty_screen_split_light(sigma_s, sigma_a, airlight, forward, 1.0f, distance);
    ty_screen_transport transport;
    transport.passed = ty_screen_down_fraction_at(down_fraction, measure) * light.scattered;
    transport.stays = light.attenuated + (light.scattered - transport.passed);
    transport.airlight = light.airlight;
    return transport;
}

/* The symmetric filter between levels, weights from the center outwards; the same in both directions, except that two
 * taps are upsampled with four, which avoids blocks. Four taps: Burt 1981, as in Elek 2013; six: binomial. */
typedef struct ty_screen_taps {
    int32_t reach; /* taps on each side: 1, 2 or 3 */
    float down[3]; /* sum 1/2; half of up, except for two taps */
    int32_t reach_up;
    float up[3]; /* weights of coarse texels at distance 0, 1 (towards the fine texel), -1; sum 1 */
} ty_screen_taps;

TY_FN ty_screen_taps ty_screen_choose_taps(int32_t filter) {
    const ty_screen_taps two = {1, {0.5f, 0.0f, 0.0f}, 2, {0.75f, 0.25f, 0.0f}};
    const ty_screen_taps four = {2, {0.37f, 0.13f, 0.0f}, 2, {0.74f, 0.26f, 0.0f}};
    const ty_screen_taps six = {3, {0.3125f, 0.15625f, 0.03125f}, 3, {0.625f, 0.3125f, 0.0625f}};
    return filter == 2 ? two : filter == 4 ? four : six;
}

/* Weight of texel `coarse` of the next level, which has `count` texels, in the upsampling of texel `fine`; clamped at
 * the edges. */
TY_FN float ty_screen_up_weight(ty_screen_taps taps, int32_t fine, int32_t coarse, int32_t count) {
    const int32_t nearest = fine / 2, offset = (fine & 1) != 0 ? 1 : -1;
    int32_t second = nearest + offset, third = nearest - offset;
    second = second < 0 ? 0 : second >= count ? count - 1 : second;
    third = third < 0 ? 0 : third >= count ? count - 1 : third;
    return (coarse == nearest ? taps.up[0] : 0.0f) + (coarse == second ? taps.up[1] : 0.0f) +
           (coarse == third ? taps.up[2] : 0.0f);
}

/* The texel of `count` that is nearest to i; min and max, by which compilers contract the sums of the callers alike. */
TY_FN int32_t ty_screen_nearest(int32_t i, int32_t count) {
    const int32_t low = i < count - 1 ? i : count - 1;
    return low > 0 ? low : 0;
}

/* A texel of a row that is upsampled from one of `width` texels of the next level. */
TY_FN float ty_screen_upsample(TY_GLOBAL const ty_screen_taps* taps, TY_GLOBAL const float* row, int32_t width,
                               int32_t x) {
    const int32_t nearest = x / 2, offset = (x & 1) != 0 ? 1 : -1;
    return taps->up[0] * row[nearest] + taps->up[1] * row[ty_screen_nearest(nearest + offset, width)] +
           taps->up[2] * row[ty_screen_nearest(nearest - offset, width)];
}

#define TY_SCREEN_DOWN_WEIGHTS 6

/* Maximum number of texels with explicit weights: those before begin and from end on. */
#define TY_SCREEN_EDGES 6

TY_FN int32_t ty_screen_edge_begin(int32_t count) {
    return count < 2 ? count : 2;
}

TY_FN int32_t ty_screen_edge_end(int32_t count) {
    const int32_t begin = ty_screen_edge_begin(count);
    return count - 4 > begin ? count - 4 : begin;
}

/* Weights of texels 2 coarse - 2 .. 2 coarse + 3 of a level (`fine_count` texels) in texel `coarse` of the next: the
 * transpose of the upsampling, so that edges lose no light. area: fraction of each texel inside the image, along one
 * axis. Returns the area of the coarse texel. */
TY_FN float ty_screen_down_weights(ty_screen_taps taps, TY_GLOBAL const float* area, int32_t fine_count, int32_t coarse,
                                   float weights[TY_SCREEN_DOWN_WEIGHTS]) {
    const int32_t count = (fine_count + 1) / 2;
    float sum = 0.0f;
    for (int32_t i = 0; i < TY_SCREEN_DOWN_WEIGHTS; ++i) {
        const int32_t fine = 2 * coarse - 2 + i;
        const int32_t inside = fine >= 0 && fine < fine_count;
        const float up_weight = taps.reach == 1 ? (fine / 2 == coarse ? 1.0f : 0.0f)
                                                : ty_screen_up_weight(taps, fine < 0 ? 0 : fine, coarse, count);
        weights[i] = inside ? up_weight * area[fine] : 0.0f;
        sum += weights[i];
    }
    for (int32_t i = 0; i < TY_SCREEN_DOWN_WEIGHTS; ++i) weights[i] /= sum;
    return 0.5f * sum;
}

/* Variance added by descending a level and ascending again, in pixels^2 of the finer level. */
TY_FN float ty_screen_taps_variance(ty_screen_taps taps) {
    const float down = 2.0f * (taps.down[0] * 0.25f + taps.down[1] * 2.25f + taps.down[2] * 6.25f);
    const float up = taps.up[0] * 0.25f + taps.up[1] * 2.25f + taps.up[2] * 6.25f;
    return down + up;
}

/* Texel (x, y) of a plane that is upsampled from one of width x height texels of the next level. */
TY_FN float ty_screen_upsample_plane(TY_GLOBAL const ty_screen_taps* taps, TY_GLOBAL const float* plane, int32_t width,
                                     int32_t height, int32_t x, int32_t y) {
    const int32_t offset = (y & 1) != 0 ? 1 : -1;
    const int32_t rows[3] = {y / 2, ty_screen_nearest(y / 2 + offset, height),
                             ty_screen_nearest(y / 2 - offset, height)};
    float sum = 0.0f;
    for (int32_t i = 0; i < taps->reach_up; ++i)
        sum += taps->up[i] * ty_screen_upsample(taps, plane + (ptrdiff_t)rows[i] * width, width, x);
    return sum;
}

/* Texel (x, y) of the next level of a plane of `width` columns, by the weights of ty_screen_down_weights along both
 * axes. */
TY_FN float ty_screen_downsample_plane(TY_GLOBAL const float* plane, int32_t width,
                                       TY_GLOBAL const float across[TY_SCREEN_DOWN_WEIGHTS],
                                       TY_GLOBAL const float down[TY_SCREEN_DOWN_WEIGHTS], int32_t x, int32_t y) {
    float sum = 0.0f;
    for (int32_t j = 0; j < TY_SCREEN_DOWN_WEIGHTS; ++j) {
        TY_GLOBAL const float* row = plane + (ptrdiff_t)(2 * y - 2 + j) * width;
        float along = 0.0f;
        if (!(down[j] > 0.0f)) continue;
        for (int32_t i = 0; i < TY_SCREEN_DOWN_WEIGHTS; ++i)
            if (across[i] > 0.0f) along += across[i] * row[2 * x - 2 + i];
        sum += down[j] * along;
    }
    return sum;
}

#endif
