/* The exact point spread function: a Gaussian of the width of each source, sampled at pixels. */
#ifndef TY_METHOD_SCREEN_REFERENCE_K_H
#define TY_METHOD_SCREEN_REFERENCE_K_H

#include "base/kernel.h"

/* Variance, pixels^2, below which light stays in its pixel to single precision. */
#define TY_SCREEN_MIN_VARIANCE 1e-3f
/* Extent of a Gaussian in standard deviations, in single precision: exp(-18) = 1.5e-8. */
#define TY_SCREEN_REACH 6.0f

/* Sharpness below which sums over a Gaussian equal integrals (standard deviations above 8 pixels). */
#define TY_SCREEN_SMOOTH 0.0078f

/* The unnormalised Gaussian, at distance^2 in pixels^2. */
TY_FN float ty_screen_gaussian(float sharpness, float distance_squared) {
    return ty_exp_neg(ty_minf(sharpness * distance_squared, 87.0f));
}

/* The integral of the Gaussian from 0 to x, half a pixel beyond the last sample, with the Euler-Maclaurin correction of
 * the sum (the slope there over 24). */
TY_FN float ty_screen_gaussian_half(float sharpness, float x) {
    const float integral = 0.5f * sqrtf(TY_PI / sharpness) * erff(sqrtf(sharpness) * x);
    return integral + sharpness * x * ty_screen_gaussian(sharpness, x * x) * (1.0f / 12.0f);
}

/* The sum of the Gaussian point spread function over pixels -before..after along one axis: Sec. 3.3 (Elek 2013). */
TY_FN float ty_screen_gaussian_sum(float sharpness, int32_t before, int32_t after) {
    if (sharpness < TY_SCREEN_SMOOTH)
        return ty_screen_gaussian_half(sharpness, (float)before + 0.5f) +
               ty_screen_gaussian_half(sharpness, (float)after + 0.5f);
    const float reach = TY_SCREEN_REACH * sqrtf(0.5f / sharpness) + 1.0f;
    const int32_t low = reach < (float)before ? (int32_t)reach : before;
    const int32_t high = reach < (float)after ? (int32_t)reach : after;
    float sum = 0.0f;
    for (int32_t i = -low; i <= high; ++i) sum += ty_screen_gaussian(sharpness, (float)i * (float)i);
    return sum;
}

#endif
