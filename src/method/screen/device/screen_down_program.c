/* Texels of the next level from the light that a level passes on, on devices. */
#include "device/entry.k.h"
#include "method/screen/device/launch.h"

TY_DEVICE_ENTRY(screen_down, ty_screen_launch) {
    TY_GLOBAL const ty_screen_device_level *level = &arguments->level, *next = &arguments->next;
    const int64_t texels = (int64_t)level->width * level->height, next_texels = (int64_t)next->width * next->height;
    const int32_t x = (int32_t)(index % next->width), y = (int32_t)(index / next->width);
    for (int32_t plane = 0; plane < 6; ++plane)
        next->planes[plane * next_texels + index] = ty_screen_downsample_plane(
            arguments->passed + plane * texels, level->width, level->across + TY_SCREEN_DOWN_WEIGHTS * x,
            level->down + TY_SCREEN_DOWN_WEIGHTS * y, x, y);
}
