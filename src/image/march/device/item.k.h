/* One item of the marcher on a device, with all that its kernels call. */
#ifndef TY_IMAGE_MARCH_DEVICE_ITEM_K_H
#define TY_IMAGE_MARCH_DEVICE_ITEM_K_H

#include "device/entry.k.h"
#include "image/march/channels.k.h"
#include "image/march/device/launch.h"
#include "image/march/pixel.k.h"
#include "scene/surfaces/bvh_accel.k.h"
#include "scene/surfaces/surface_gloss.k.h"

/* Column and row of an item of an array with so many columns. */
TY_FN int32_t ty_march_column(TY_GLOBAL const ty_march_launch* launch, int64_t index, int32_t columns) {
    return (int32_t)((launch->begin + index) % columns);
}

TY_FN int32_t ty_march_row(TY_GLOBAL const ty_march_launch* launch, int64_t index, int32_t columns) {
    return (int32_t)((launch->begin + index) / columns);
}

TY_FN void ty_march_count(TY_GLOBAL const ty_march_launch* launch, int64_t index, uint32_t steps) {
    if (launch->steps != NULL) launch->steps[index] = steps;
}

/* Stores the channels of a pixel. */
TY_FN void ty_march_store(TY_GLOBAL const ty_march_launch* launch, int64_t index, const ty_march_pixel* pixel) {
    const size_t pixels = (size_t)launch->width * (size_t)launch->height, at = (size_t)(launch->begin + index);
    for (int32_t k = 0; k < launch->channel_count; ++k) {
        const ty_march_channel channel = launch->channels[k];
        TY_GLOBAL const float* unscattered = launch->unscattered[channel.c];
        launch->planes[(size_t)k * pixels + at] = ty_pixel_value(pixel, channel.aov, channel.c, launch->request->spp,
                                                                 unscattered != NULL ? unscattered[at] : 0.0f);
    }
}

#endif
