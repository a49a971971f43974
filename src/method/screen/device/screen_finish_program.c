/* Pixels with the light of level 1, on devices. */
#include "device/entry.k.h"
#include "method/screen/device/launch.h"

TY_DEVICE_ENTRY(screen_finish, ty_screen_launch) {
    TY_GLOBAL const ty_screen_device_level* next = &arguments->next;
    const int32_t width = arguments->params.width;
    const int64_t pixels = (int64_t)width * arguments->params.height;
    const int64_t next_texels = (int64_t)next->width * next->height;
    for (int32_t c = 0; c < 3; ++c)
        arguments->out[c * pixels + index] +=
            ty_screen_upsample_plane(&arguments->taps, next->planes + c * next_texels, next->width, next->height,
                                     (int32_t)(index % width), (int32_t)(index / width));
}
