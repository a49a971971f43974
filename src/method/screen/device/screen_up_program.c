/* Light that stays in the texels of a level, with that of the next, on devices. */
#include "device/entry.k.h"
#include "method/screen/device/launch.h"

TY_DEVICE_ENTRY(screen_up, ty_screen_launch) {
    TY_GLOBAL const ty_screen_device_level *level = &arguments->level, *next = &arguments->next;
    const int64_t texels = (int64_t)level->width * level->height, next_texels = (int64_t)next->width * next->height;
    const int32_t x = (int32_t)(index % level->width), y = (int32_t)(index / level->width);
    for (int32_t c = 0; c < 3; ++c) {
        TY_GLOBAL float* light = &level->planes[c * texels + index];
        const float moment = level->planes[(3 + c) * texels + index];
        const float stays = *light - ty_screen_passed_fraction(level->down_fraction[c], *light, moment) * *light;
        *light = stays + ty_screen_upsample_plane(&arguments->taps, next->planes + c * next_texels, next->width,
                                                  next->height, x, y);
    }
}
