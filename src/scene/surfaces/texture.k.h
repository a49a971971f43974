/* Texture lookup. */
#ifndef TY_SCENE_SURFACES_TEXTURE_K_H
#define TY_SCENE_SURFACES_TEXTURE_K_H

#include "base/kernel.h"

/* Texture view for kernels. Without rgba8 and floats there is no texture. */
typedef struct ty_texture_view {
    TY_GLOBAL const uint8_t* rgba8; /* 4 per texel */
    TY_GLOBAL const float* decode;  /* linear value of each of the 256 codes */
    TY_GLOBAL const float* floats;  /* 4 per texel, linear */
    int32_t width, height;
    int32_t wrap[2]; /* ty_wrap */
    int32_t nearest;
} ty_texture_view;

TY_FN bool ty_texture_exists(TY_GLOBAL const ty_texture_view* texture) {
    return texture->rgba8 != NULL || texture->floats != NULL;
}

/* Wraps texel index i to [0, count); for repeating textures i is at most one period outside. */
TY_FN int32_t ty_texture_wrap(int32_t i, int32_t count, int32_t wrap) {
    if (wrap == 1) return i < 0 ? 0 : i >= count ? count - 1 : i;
    const int32_t period = wrap == 2 ? 2 * count : count;
    i = i < 0 ? i + period : i >= period ? i - period : i;
    return i < count ? i : period - 1 - i;
}

/* Texel (x, y) within the texture. */
TY_FN void ty_texture_texel(TY_GLOBAL const ty_texture_view* texture, int32_t x, int32_t y, float rgba[4]) {
    const size_t at = 4 * ((size_t)x + (size_t)texture->width * (size_t)y);
    if (texture->floats != NULL) {
        for (int c = 0; c < 4; ++c) rgba[c] = texture->floats[at + (size_t)c];
        return;
    }
    for (int c = 0; c < 3; ++c) rgba[c] = texture->decode[texture->rgba8[at + (size_t)c]];
    rgba[3] = (float)texture->rgba8[at + 3] * (1.0f / 255.0f);
}

/* Reduces a coordinate in periods to a range with texel indices -count to 2 count; non-finite ones count as an edge. */
TY_FN float ty_texture_coordinate(float u, int32_t wrap) {
    if (wrap == 1) return ty_clampf(u, -1.0f, 2.0f);
    const float period = wrap == 2 ? 2.0f : 1.0f;
    const float reduced = u - period * floorf(u / period);
    return reduced == reduced ? reduced : 0.0f;
}

/* Linear colour and alpha at (u, v): bilinear between texel centers, or the nearest texel. */
TY_FN void ty_texture_lookup(TY_GLOBAL const ty_texture_view* texture, float u, float v, float rgba[4]) {
    const float x = ty_texture_coordinate(u, texture->wrap[0]) * (float)texture->width;
    const float y = ty_texture_coordinate(v, texture->wrap[1]) * (float)texture->height;
    if (texture->nearest != 0) {
        ty_texture_texel(texture, ty_texture_wrap((int32_t)floorf(x), texture->width, texture->wrap[0]),
                         ty_texture_wrap((int32_t)floorf(y), texture->height, texture->wrap[1]), rgba);
        return;
    }
    const float left = floorf(x - 0.5f), top = floorf(y - 0.5f);
    const float weight_x = x - 0.5f - left, weight_y = y - 0.5f - top;
    int32_t column[2], line[2];
    for (int i = 0; i < 2; ++i) {
        column[i] = ty_texture_wrap((int32_t)left + i, texture->width, texture->wrap[0]);
        line[i] = ty_texture_wrap((int32_t)top + i, texture->height, texture->wrap[1]);
    }
    float row[2][4];
    for (int j = 0; j < 2; ++j) {
        float a[4], b[4];
        ty_texture_texel(texture, column[0], line[j], a);
        ty_texture_texel(texture, column[1], line[j], b);
        for (int c = 0; c < 4; ++c) row[j][c] = ty_lerpf(a[c], b[c], weight_x);
    }
    for (int c = 0; c < 4; ++c) rgba[c] = ty_lerpf(row[0][c], row[1][c], weight_y);
}

#endif
