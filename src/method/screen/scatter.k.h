/* Light spread by its own width: what of it stays at a level of the pyramid, what goes on to the next, and the filters
 * from level to level.
 *
 * A texel holds, per channel, light E and Q = E times the measure of how far this light shall spread: the variance of
 * its Gaussian (Eq. 2), or the optical thickness that it was scattered over. Both are linear, so filtering mixes them
 * rightly: Q / E is the mean, weighted by light. Down a level and up again adds a known variance; light whose variance
 * lies between those of two levels is shared between them so that the variance of the sum is right. */
#ifndef TY_METHOD_SCREEN_SCATTER_K_H
#define TY_METHOD_SCREEN_SCATTER_K_H

#include "base/kernel.h"

/* Polynomial shares: terms in z = 2 t / TOP - 1, t = tau / (tau + SCALE), cut at TOP (tau = 76). */
#define TY_SCREEN_FRACTION_TERMS 8
#define TY_SCREEN_FRACTION_SCALE 4.0f
#define TY_SCREEN_FRACTION_T_MAX 0.95f

/* The share of a level's light that goes on to the next, as a function of its measure. */
typedef struct ty_screen_down_fraction {
    int32_t small_angle;
    float low, inverse_range;           /* variance: of the level, and 1 / (what the next holds more) */
    float terms[TY_SCREEN_FRACTION_TERMS]; /* small angle: from the constant on */
} ty_screen_down_fraction;

TY_FN float ty_screen_down_fraction_at(ty_screen_down_fraction share, float measure) {
    if (!share.small_angle) return ty_clampf((measure - share.low) * share.inverse_range, 0.0f, 1.0f);
    const float t = ty_minf(measure / (measure + TY_SCREEN_FRACTION_SCALE), TY_SCREEN_FRACTION_T_MAX);
    const float z = t * (2.0f / TY_SCREEN_FRACTION_T_MAX) - 1.0f;
    float sum = share.terms[TY_SCREEN_FRACTION_TERMS - 1];
    for (int32_t i = TY_SCREEN_FRACTION_TERMS - 2; i >= 0; --i) sum = sum * z + share.terms[i];
    return ty_clampf(sum, 0.0f, 1.0f);
}

/* The mean measure of a texel's light; 0 where there is none. */
TY_FN float ty_screen_mean_measure(float light, float moment) {
    return moment / (light + 1e-30f);
}

/* The filter from one level to the next, symmetric, from the middle outwards; the same both ways, but that two taps go
 * up as four, which keeps pictures free of blocks. Four taps: Burt 1981, as in the paper; six: binomial. */
typedef struct ty_screen_taps {
    int32_t reach; /* taps on each side: 1, 2 or 3 */
    float down[3]; /* sum 1/2; half of up, but for two taps */
    int32_t reach_up;
    float up[3]; /* of the coarse texels at distance 0, 1 (towards the fine one), -1; sum 1 */
} ty_screen_taps;

TY_FN ty_screen_taps ty_screen_choose_taps(int32_t filter) {
    const ty_screen_taps two = {1, {0.5f, 0.0f, 0.0f}, 2, {0.75f, 0.25f, 0.0f}};
    const ty_screen_taps four = {2, {0.37f, 0.13f, 0.0f}, 2, {0.74f, 0.26f, 0.0f}};
    const ty_screen_taps six = {3, {0.3125f, 0.15625f, 0.03125f}, 3, {0.625f, 0.3125f, 0.0625f}};
    return filter == 2 ? two : filter == 4 ? four : six;
}

/* With what weight texel `fine` of a level looks at texel `coarse` of the next, which has `count` of them; outside
 * counts as the edge. */
TY_FN float ty_screen_up_weight(ty_screen_taps taps, int32_t fine, int32_t coarse, int32_t count) {
    const int32_t middle = fine / 2, towards = (fine & 1) != 0 ? 1 : -1;
    int32_t far = middle + towards, behind = middle - towards;
    far = far < 0 ? 0 : far >= count ? count - 1 : far;
    behind = behind < 0 ? 0 : behind >= count ? count - 1 : behind;
    return (coarse == middle ? taps.up[0] : 0.0f) + (coarse == far ? taps.up[1] : 0.0f) +
           (coarse == behind ? taps.up[2] : 0.0f);
}

#define TY_SCREEN_DOWN_WEIGHTS 6

/* Of `count` texels, those before begin and from end on may have weights of their own. */
#define TY_SCREEN_EDGES 6

TY_FN int32_t ty_screen_edge_begin(int32_t count) {
    return count < 2 ? count : 2;
}

TY_FN int32_t ty_screen_edge_end(int32_t count) {
    const int32_t begin = ty_screen_edge_begin(count);
    return count - 4 > begin ? count - 4 : begin;
}

/* The weights of texels 2 coarse - 2 .. 2 coarse + 3 of a level (`fine_count` of them) in texel `coarse` of the next:
 * what each gets from it on the way up, so that no light is lost at any edge. area: how much of each texel lies in the
 * picture, along one axis. Returns the area of the coarse one. */
TY_FN float ty_screen_down_weights(ty_screen_taps taps, TY_GLOBAL const float* area, int32_t fine_count, int32_t coarse,
                                   float weights[TY_SCREEN_DOWN_WEIGHTS]) {
    const int32_t count = (fine_count + 1) / 2;
    float sum = 0.0f;
    for (int32_t i = 0; i < TY_SCREEN_DOWN_WEIGHTS; ++i) {
        const int32_t fine = 2 * coarse - 2 + i;
        const int32_t inside = fine >= 0 && fine < fine_count;
        const float share = taps.reach == 1 ? (fine / 2 == coarse ? 1.0f : 0.0f)
                                            : ty_screen_up_weight(taps, fine < 0 ? 0 : fine, coarse, count);
        weights[i] = inside ? share * area[fine] : 0.0f;
        sum += weights[i];
    }
    for (int32_t i = 0; i < TY_SCREEN_DOWN_WEIGHTS; ++i) weights[i] /= sum;
    return 0.5f * sum;
}

/* The variance, in pixels of the finer level squared, that going down a level and up again adds. */
TY_FN float ty_screen_taps_variance(ty_screen_taps taps) {
    const float down = 2.0f * (taps.down[0] * 0.25f + taps.down[1] * 2.25f + taps.down[2] * 6.25f);
    const float up = taps.up[0] * 0.25f + taps.up[1] * 2.25f + taps.up[2] * 6.25f;
    return down + up;
}

#endif
