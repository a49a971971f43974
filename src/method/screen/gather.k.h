/* The paper's pyramid: the mask between levels, Eq. 7 (Elek 2013), the level of a distance, Eq. 10 (Elek 2013), and
 * interpolation between texels and levels, Sec. 3.5 (Elek 2013). */
#ifndef TY_METHOD_SCREEN_GATHER_K_H
#define TY_METHOD_SCREEN_GATHER_K_H

#include "method/screen/split.k.h"

#include "base/luminance.k.h"

/* Keeps luminance weights above 0 in black regions. */
#define TY_SCREEN_MIN_LUMINANCE 1e-20f

typedef struct ty_screen_mask_params {
    int32_t kind;    /* ty_screen_mask */
    float threshold; /* T, pixels */
    float width;     /* epsilon */
} ty_screen_mask_params;

/* M of Eq. 7 (Elek 2013); spread: W, pixels. */
TY_FN float ty_screen_mask_at(ty_screen_mask_params params, float spread) {
    const float t = ty_clampf((spread - params.threshold) / (params.width * params.threshold), 0.0f, 1.0f);
    const float step = spread >= params.threshold ? 1.0f : 0.0f;
    return params.kind == 0 ? 1.0f : params.kind == 1 ? step : t * t * (3.0f - 2.0f * t);
}

TY_FN float ty_screen_luminance(float r, float g, float b) {
    return ty_luminance(r, g, b) + TY_SCREEN_MIN_LUMINANCE;
}

/* Eq. 10 (Elek 2013), from the variance W^2, pixels^2; scale: c. */
TY_FN float ty_screen_level_at(float variance, float scale, float levels) {
    const float ratio = ty_maxf(variance / (scale * scale), 1.0f);
    return ty_minf(0.5f * 1.44269504f * ty_logf(ratio), levels);
}

/* Uniform cubic B-spline weights of four neighbours at t in [0, 1) between the inner two. */
TY_FN void ty_screen_cubic(float t, float weights[4]) {
    const float s = 1.0f - t;
    weights[0] = s * s * s * (1.0f / 6.0f);
    weights[1] = (4.0f + 3.0f * t * t * (t - 2.0f)) * (1.0f / 6.0f);
    weights[2] = (4.0f + 3.0f * s * s * (s - 2.0f)) * (1.0f / 6.0f);
    weights[3] = t * t * t * (1.0f / 6.0f);
}

/* Texels of four floats: scattered light and distance. */
typedef struct ty_screen_texels {
    int32_t width, height;
    TY_GLOBAL float* texels; /* 4 * width floats per row */
} ty_screen_texels;

TY_FN int32_t ty_screen_clamp_index(int32_t i, int32_t count) {
    return i < 0 ? 0 : i >= count ? count - 1 : i;
}

/* Interpolates a level at the center of pixel (x, y) of level 0; scale: 2^-level. */
TY_FN void ty_screen_fetch_cubic(ty_screen_texels level, float scale, int32_t x, int32_t y, float out[4]) {
    const float u = ((float)x + 0.5f) * scale - 0.5f, v = ((float)y + 0.5f) * scale - 0.5f;
    const int32_t i = (int32_t)(u + 1.0f) - 1, j = (int32_t)(v + 1.0f) - 1;
    float across[4], down[4], sum[16];
    ty_screen_cubic(u - (float)i, across);
    ty_screen_cubic(v - (float)j, down);
    for (int32_t k = 0; k < 16; ++k) sum[k] = 0.0f;
    const int32_t inside = i >= 1 && i + 2 < level.width;
    for (int32_t row = 0; row < 4; ++row) {
        TY_GLOBAL const float* texels =
            level.texels + (ptrdiff_t)ty_screen_clamp_index(j - 1 + row, level.height) * 4 * level.width;
        if (inside) {
            for (int32_t k = 0; k < 16; ++k) sum[k] += down[row] * texels[4 * (i - 1) + k];
        } else {
            for (int32_t k = 0; k < 16; ++k)
                sum[k] += down[row] * texels[4 * ty_screen_clamp_index(i - 1 + k / 4, level.width) + k % 4];
        }
    }
    for (int32_t c = 0; c < 4; ++c)
        out[c] = across[0] * sum[c] + across[1] * sum[4 + c] + across[2] * sum[8 + c] + across[3] * sum[12 + c];
}

/* Interpolates at a fractional level, linearly between two: Sec. 3.5 (Elek 2013). Level 0 is read unfiltered. */
TY_FN void ty_screen_fetch(TY_GLOBAL const ty_screen_texels* levels, int32_t count, float level, int32_t x, int32_t y,
                           float out[4]) {
    int32_t lower = (int32_t)level;
    lower = lower > count - 1 ? count - 1 : lower;
    const int32_t upper = lower + 1 > count - 1 ? count - 1 : lower + 1;
    const float fraction = level - (float)lower;
    float fine[4], coarse[4];
    if (lower == 0) {
        for (int32_t c = 0; c < 4; ++c) fine[c] = levels[0].texels[((ptrdiff_t)y * levels[0].width + x) * 4 + c];
    } else {
        ty_screen_fetch_cubic(levels[lower], 1.0f / (float)(1 << lower), x, y, fine);
    }
    if (fraction <= 0.0f || upper == lower) {
        for (int32_t c = 0; c < 4; ++c) out[c] = fine[c];
        return;
    }
    ty_screen_fetch_cubic(levels[upper], 1.0f / (float)(1 << upper), x, y, coarse);
    for (int32_t c = 0; c < 4; ++c) out[c] = ty_lerpf(fine[c], coarse[c], fraction);
}

#endif
