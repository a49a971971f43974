/* What the medium takes from a pixel's light on its way to the camera, and how far it spreads what it scatters: Eq. 2-5
 * of Elek et al. 2013, with the coefficients of Eq. 4 set right (absorption first, then scattering). */
#ifndef TY_METHOD_SCREEN_SPLIT_K_H
#define TY_METHOD_SCREEN_SPLIT_K_H

#include "base/kernel.h"

/* The largest radiance that +Inf stands for: the largest half. */
#define TY_SCREEN_BRIGHTEST 65504.0f
/* Beyond these, sums and products of single precision overflow on the way: radiance, and variance in pixels^2. */
#define TY_SCREEN_RADIANCE_MAX 1e29f
#define TY_SCREEN_VARIANCE_MAX 1e9f
#define TY_SCREEN_DISTANCE_MAX 1e15f
/* exp(-x) below single precision's range: nothing is left. */
#define TY_SCREEN_OPAQUE 87.0f

/* What is the same for all pixels, per channel where there are three. */
typedef struct ty_screen_params {
    int32_t width, height;
    float sigma_s[3], sigma_a[3]; /* 1/m */
    float airlight[3];            /* environment * sigma_s / sigma_t, W m^-2 sr^-1 */
    float forward[3];             /* fraction of the scattered light that arrives */
    float slope[3]; /* measure of spread: slope D / (1 + bend D^2). Eq. 2 squared, in pixels, or sigma_s D */
    float bend[3];
    float angle[3];              /* of the small-angle spread, pixels */
    float mean_slope, mean_bend; /* the same for the mean of the channels' coefficients: the paper's single W */
    int32_t planar;              /* distances are along the camera's axis */
    float center_x, center_y;    /* principal point, pixels */
    float inverse_focal_x, inverse_focal_y; /* 1/pixels */
    float unknown;                          /* m */
} ty_screen_params;

/* How much longer the way to pixel (x, y) is than its depth along the camera's axis. */
TY_FN float ty_screen_slant(ty_screen_params params, int32_t x, int32_t y) {
    const float dx = ((float)x + 0.5f - params.center_x) * params.inverse_focal_x;
    const float dy = ((float)y + 0.5f - params.center_y) * params.inverse_focal_y;
    return sqrtf(1.0f + dx * dx + dy * dy);
}

/* A distance that can be worked with, m; *missing becomes 1, else 0, where there is none. */
TY_FN float ty_screen_distance(float distance, float unknown, int32_t* missing) {
    const int32_t known = distance > 0.0f && distance <= TY_FLOAT_MAX;
    *missing = known ? 0 : 1;
    return known ? ty_minf(distance, TY_SCREEN_DISTANCE_MAX) : unknown;
}

/* A radiance that can be worked with: 0 for what is negative or not a number, the largest half for what is beyond
 * `highest`. *mended becomes 1 where the given one was not such. */
TY_FN float ty_screen_mend(float radiance, float highest, int32_t* mended) {
    const int32_t low = radiance >= 0.0f, high = radiance <= highest;
    *mended |= low && high ? 0 : 1;
    return low ? (high ? radiance : TY_SCREEN_BRIGHTEST) : 0.0f;
}

/* Eq. 2 and 5, squared and in pixels: W^2 (focal / D)^2. D in m. */
TY_FN float ty_screen_variance(float slope, float bend, float distance) {
    return ty_minf(slope * distance / (1.0f + bend * distance * distance), TY_SCREEN_VARIANCE_MAX);
}

typedef struct ty_screen_parts {
    float attenuated; /* I', Eq. 3 */
    float scattered;  /* I0, Eq. 4 */
    float airlight;   /* what the environment adds */
} ty_screen_parts;

/* One channel of a pixel. */
TY_FN ty_screen_parts ty_screen_split_light(float sigma_s, float sigma_a, float airlight, float forward, float radiance,
                                            float distance) {
    const float absorbed = ty_exp_neg(ty_minf(sigma_a * distance, TY_SCREEN_OPAQUE));
    const float kept = ty_exp_neg(ty_minf(sigma_s * distance, TY_SCREEN_OPAQUE));
    ty_screen_parts parts;
    parts.attenuated = radiance * (absorbed * kept);
    parts.scattered = forward * (radiance * (absorbed * (1.0f - kept)));
    parts.airlight = airlight * (1.0f - absorbed * kept);
    return parts;
}

#endif
