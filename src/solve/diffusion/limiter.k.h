/* Flux limiters F(R), Table 2 (Koerner 2014): F(0) = 1/3, R F(R) <= 1 and -> 1 as R grows. */
#ifndef TY_SOLVE_DIFFUSION_LIMITER_K_H
#define TY_SOLVE_DIFFUSION_LIMITER_K_H

#include "base/kernel.h"

/* Larger R overflow when squared; F there is 1 / R to single precision. */
#define TY_LIMITER_R_MAX 1e18f

TY_FN float ty_limiter_sum(float r) {
    return 1.0f / (3.0f + r);
}

TY_FN float ty_limiter_max(float r) {
    return 1.0f / ty_maxf(3.0f, r);
}

TY_FN float ty_limiter_kershaw(float r) {
    return 2.0f / (3.0f + sqrtf(9.0f + 4.0f * r * r));
}

/* (3^n + r^n)^(-1/n), factored into the larger term and a ratio, so that no power overflows. */
TY_FN float ty_limiter_larsen(float r, float n) {
    const float large = ty_maxf(3.0f, r), ratio = ty_maxf(ty_minf(3.0f, r) / large, 1e-30f);
    const float power = ty_exp_neg(ty_minf(-n * ty_logf(ratio), 87.0f));
    return ty_exp_neg(ty_logf(1.0f + power) / n) / large;
}

/* (coth r - 1/r) / r (Levermore and Pomraning 1981); below 1, where that loses digits, its series. */
TY_FN float ty_limiter_levermore_pomraning(float r) {
    const float s = ty_minf(r * r, 1.0f);
    float series = -2.1644043e-6f + s * 2.1926e-7f;
    series = 2.13777992e-5f + s * series;
    series = -2.11640212e-4f + s * series;
    series = 2.11640212e-3f + s * series;
    series = -2.22222222e-2f + s * series;
    series = 0.333333333f + s * series;
    const float x = ty_maxf(r, 1.0f), e = ty_exp_neg(ty_minf(2.0f * x, 87.0f));
    const float closed = ((1.0f + e) / (1.0f - e) - 1.0f / x) / x;
    return r < 1.0f ? series : closed;
}

/* F(r) of a ty_limiter, Table 2 (Koerner 2014); n is the power of Larsen's. */
TY_FN float ty_limiter_value(int32_t limiter, float n, float r) {
    const float bounded = ty_minf(r, TY_LIMITER_R_MAX);
    switch (limiter) {
    case 1: return ty_limiter_sum(bounded);
    case 2: return ty_limiter_max(bounded);
    case 3: return ty_limiter_kershaw(bounded);
    case 4: return ty_limiter_larsen(bounded, n);
    case 5: return ty_limiter_levermore_pomraning(bounded);
    default: return 1.0f / 3.0f;
    }
}

#endif
