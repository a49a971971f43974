/* Light passed on from a level of the pyramid, on devices. */
#include "device/entry.k.h"
#include "method/screen/device/launch.h"

TY_DEVICE_ENTRY(screen_pass, ty_screen_launch) {
    TY_GLOBAL const ty_screen_device_level* level = &arguments->level;
    const int64_t texels = (int64_t)level->width * level->height;
    for (int32_t c = 0; c < 3; ++c) {
        const float light = level->planes[c * texels + index], moment = level->planes[(3 + c) * texels + index];
        const float fraction = ty_screen_passed_fraction(level->down_fraction[c], light, moment);
        arguments->passed[c * texels + index] = fraction * light;
        arguments->passed[(3 + c) * texels + index] = fraction * moment;
    }
}
