/* A tube of a beam through one slab of cells. Tubes are as wide as cells and parallel to the beam; on their way through
 * a slab they overlap three cells of a row and three rows, on the mean over the way by `weight` each. Tubes take the
 * mean extinction of what they overlap, and cells the mean light of the tubes that overlap them, with the same weights:
 * what tubes lose is what cells absorb. */
#ifndef TY_DIRECT_BEAM_K_H
#define TY_DIRECT_BEAM_K_H

#include "base/kernel.h"

/* e^-x for any x >= 0. */
TY_FN float ty_decay(float x) {
    return ty_exp_neg(ty_minf(x, 87.0f));
}

/* (1 - e^-x) / x for x >= 0, given e^-x. */
TY_FN float ty_mean_decay(float x, float decay) {
    const float series = 1.0f - x * (0.5f - x * (1.0f / 6.0f - x * (1.0f / 24.0f)));
    return x < 0.03f ? series : (1.0f - decay) / ty_maxf(x, 0.03f);
}

/* The mean of three neighbours by their weights. */
TY_FN float ty_share_three(float a, float b, float c, const float weight[3]) {
    return a * weight[0] + b * weight[1] + c * weight[2];
}

/* Between two neighbours. */
TY_FN float ty_share_between(float first, float second, float share) {
    return first * (1.0f - share) + second * share;
}

#endif
