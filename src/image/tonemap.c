/* The display transform, and the inverse sRGB curve. */
#include "image/image.h"

#include "base/context.h"

#include <math.h>

/* Identity up to the knee k = 0.5, then the shoulder k + (1 - k) y / (1 + y) with y = (x - k) / (1 - k): continuous
 * with slope 1 at the knee, and tending to 1. */
static float filmic(float x) {
    const float knee = 0.5f;
    if (x <= knee) return x;
    const float y = (x - knee) / (1 - knee);
    return knee + (1 - knee) * (1 - 1 / (1 + y));
}

/* IEC 61966-2-1, linear to display. */
static float srgb(float x) {
    return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
}

float ty_linear_from_srgb(float x) {
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

uint8_t ty_tone_byte(float value, float scale, ty_tone_curve curve) {
    float x = value * scale;
    if (!(x > 0)) return 0; /* NaN too */
    if (curve == TY_TONE_FILMIC) x = filmic(x);
    return (uint8_t)(255 * srgb(x < 1 ? x : 1) + 0.5f);
}

ty_result ty_image_tonemap(ty_context* context, const ty_image* image, double exposure, ty_tone_curve curve,
                           uint8_t* rgb8) {
    if (image == NULL || rgb8 == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_tonemap: an argument is NULL");
    if (!isfinite(exposure)) return ty_fail(context, TY_ERROR_ARGUMENT, "the exposure is not finite");
    const float* planes[3];
    if (!ty_image_rgb_planes(image, planes))
        return ty_fail(context, TY_ERROR_ARGUMENT, "an image to show has neither R, G and B nor one channel alone");
    const float scale = (float)exp2(exposure);
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; ++i)
        for (int c = 0; c < 3; ++c) rgb8[3 * i + (size_t)c] = ty_tone_byte(planes[c][i], scale, curve);
    return TY_OK;
}
