/* Attenuation along a tube of parallel light through one slab of cells. Tubes are as wide as cells and parallel to the
 * light; within a slab a tube overlaps three cells of a row and three rows, with the mean overlap as weights. Tubes
 * take the weighted mean extinction of these cells, and cells the weighted mean light of the tubes: the power that
 * tubes lose is the power that cells absorb. */
#ifndef TY_DIRECT_MEDIA_ATTENUATION_K_H
#define TY_DIRECT_MEDIA_ATTENUATION_K_H

#include "base/kernel.h"

/* Attenuation e^-x for any x >= 0. */
TY_FN float ty_attenuation(float x) {
    return ty_exp_neg(ty_minf(x, 87.0f));
}

/* Mean attenuation (1 - e^-x) / x over a path, for x >= 0, given e^-x. */
TY_FN float ty_mean_attenuation(float x, float attenuation) {
    const float series = 1.0f - x * (0.5f - x * (1.0f / 6.0f - x * (1.0f / 24.0f)));
    return x < 0.03f ? series : (1.0f - attenuation) / ty_maxf(x, 0.03f);
}

/* Weighted sum of three neighbours. */
TY_FN float ty_weighted_sum3(float a, float b, float c, const float weight[3]) {
    return a * weight[0] + b * weight[1] + c * weight[2];
}

/* Linear interpolation that returns `second` exactly at t = 1, which ty_lerpf does not. */
TY_FN float ty_lerp_exact(float first, float second, float t) {
    return first * (1.0f - t) + second * t;
}

#endif
