/* Equirectangular maps of scalars. */
#ifndef TY_SCENE_LIGHTS_ENVIRONMENT_MAP_K_H
#define TY_SCENE_LIGHTS_ENVIRONMENT_MAP_K_H

#include "base/kernel.h"

/* Bilinear between texel centers of an equirectangular map; u: any, v in [0, 1] from the top. */
TY_FN float ty_environment_map_at(const float* map, int32_t width, int32_t height, float u, float v) {
    const float x = (u - floorf(u)) * (float)width - 0.5f;
    const float y = ty_clampf(v * (float)height - 0.5f, 0.0f, (float)(height - 1));
    const int32_t left = (int32_t)floorf(x), top = (int32_t)y, bottom = top + 1 < height ? top + 1 : top;
    const int32_t x0 = (left + width) % width, x1 = (left + 1) % width;
    const float weight_x = x - (float)left;
    return ty_lerpf(ty_lerpf(map[width * top + x0], map[width * top + x1], weight_x),
                    ty_lerpf(map[width * bottom + x0], map[width * bottom + x1], weight_x), y - (float)top);
}

#endif
