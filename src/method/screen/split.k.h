/* Attenuation of a pixel's light by the medium, and the spread of its scattered light: Eq. 2-5 (Elek 2013), with the
 * coefficients of Eq. 4 (Elek 2013) corrected (absorption first, then scattering). */
#ifndef TY_METHOD_SCREEN_SPLIT_K_H
#define TY_METHOD_SCREEN_SPLIT_K_H

#include "base/kernel.h"

/* Replacement of +Inf radiance: the largest half-precision float. */
#define TY_SCREEN_HALF_MAX 65504.0f
/* Limits beyond which sums and products overflow single precision: radiance, variance in pixels^2, and distance in m.
 */
#define TY_SCREEN_RADIANCE_MAX 1e29f
#define TY_SCREEN_VARIANCE_MAX 1e9f
#define TY_SCREEN_DISTANCE_MAX 1e15f
/* Optical depth with zero transmittance in single precision. */
#define TY_SCREEN_OPAQUE 87.0f

/* Parameters shared by all pixels, per channel where there are three. */
typedef struct ty_screen_params {
    int32_t width, height;
    float sigma_s[3], sigma_a[3]; /* 1/m */
    float airlight[3];            /* environment * sigma_s / sigma_t, W m^-2 sr^-1 */
    float forward[3];             /* fraction of the scattered light that arrives */
    float slope[3]; /* measure of spread: slope D / (1 + curvature D^2): Eq. 2 squared (Elek 2013), in pixels, or
                       sigma_s D */
    float curvature[3];
    float angle[3]; /* of the small-angle spread, pixels */
    float mean_slope,
        mean_curvature;       /* the same for the channel means of the coefficients: the single W of Elek 2013 */
    int32_t planar;           /* 1: distances are depths along the camera axis */
    float center_x, center_y; /* principal point, pixels */
    float inverse_focal_x, inverse_focal_y; /* 1/pixels */
    float unknown;                          /* m */
} ty_screen_params;

/* Ratio of the distance of pixel (x, y) to its depth along the camera axis. */
TY_FN float ty_screen_distance_per_depth(ty_screen_params params, int32_t x, int32_t y) {
    const float dx = ((float)x + 0.5f - params.center_x) * params.inverse_focal_x;
    const float dy = ((float)y + 0.5f - params.center_y) * params.inverse_focal_y;
    return sqrtf(1.0f + dx * dx + dy * dy);
}

/* Valid distance, m; *missing is set to 1 and the distance replaced if it is missing, else to 0. */
TY_FN float ty_screen_distance(float distance, float unknown, int32_t* missing) {
    const int32_t known = distance > 0.0f && distance <= TY_FLOAT_MAX;
    *missing = known ? 0 : 1;
    return known ? ty_minf(distance, TY_SCREEN_DISTANCE_MAX) : unknown;
}

/* Valid radiance: 0 for negative values and NaN, the largest half above `highest`. *changed becomes 1 if the value was
 * invalid. */
TY_FN float ty_screen_sanitize(float radiance, float highest, int32_t* changed) {
    const int32_t low = radiance >= 0.0f, high = radiance <= highest;
    *changed |= low && high ? 0 : 1;
    return low ? (high ? radiance : TY_SCREEN_HALF_MAX) : 0.0f;
}

/* Eq. 2 and 5 (Elek 2013), squared and in pixels: W^2 (focal / D)^2. D in m. */
TY_FN float ty_screen_variance(float slope, float curvature, float distance) {
    return ty_minf(slope * distance / (1.0f + curvature * distance * distance), TY_SCREEN_VARIANCE_MAX);
}

typedef struct ty_screen_light_split {
    float attenuated; /* I', Eq. 3 (Elek 2013) */
    float scattered;  /* I0, Eq. 4 (Elek 2013) */
    float airlight;   /* in-scattered environment light */
} ty_screen_light_split;

/* Splits one channel of a pixel: Eq. 3 and 4 (Elek 2013). */
TY_FN ty_screen_light_split ty_screen_split_light(float sigma_s, float sigma_a, float airlight, float forward,
                                                  float radiance, float distance) {
    const float unabsorbed = ty_exp_neg(ty_minf(sigma_a * distance, TY_SCREEN_OPAQUE));
    const float unscattered = ty_exp_neg(ty_minf(sigma_s * distance, TY_SCREEN_OPAQUE));
    ty_screen_light_split split;
    split.attenuated = radiance * (unabsorbed * unscattered);
    split.scattered = forward * (radiance * (unabsorbed * (1.0f - unscattered)));
    split.airlight = airlight * (1.0f - unabsorbed * unscattered);
    return split;
}

#endif
