/* The data window of an image in its frame. */
#include "image/image.h"

#include "base/context.h"

#include <string.h>

ty_result ty_image_set_frame(ty_image* image, int32_t x, int32_t y, int32_t width, int32_t height) {
    if (width < 1 || height < 1 || width > TY_IMAGE_SIDE_MAX || height > TY_IMAGE_SIDE_MAX)
        return ty_fail(image->context, TY_ERROR_ARGUMENT, "an image frame is %d x %d, outside 1..%d", (int)width,
                       (int)height, (int)TY_IMAGE_SIDE_MAX);
    if (x < -TY_IMAGE_OFFSET_MAX || y < -TY_IMAGE_OFFSET_MAX || x > TY_IMAGE_OFFSET_MAX || y > TY_IMAGE_OFFSET_MAX)
        return ty_fail(image->context, TY_ERROR_ARGUMENT, "pixels at (%d, %d) of an image frame are beyond %d", (int)x,
                       (int)y, (int)TY_IMAGE_OFFSET_MAX);
    const int32_t frame[4] = {x, y, width, height};
    memcpy(image->frame, frame, sizeof frame);
    return TY_OK;
}

void ty_image_get_frame(const ty_image* image, int32_t frame[4]) {
    memcpy(frame, image->frame, sizeof image->frame);
}

ty_window ty_image_window(const ty_image* image) {
    return (ty_window){image->frame[0], image->frame[1], image->frame[0] + image->width,
                       image->frame[1] + image->height};
}

static int32_t larger(int32_t a, int32_t b) {
    return a > b ? a : b;
}

static int32_t smaller(int32_t a, int32_t b) {
    return a < b ? a : b;
}

ty_window ty_window_intersection(ty_window a, ty_window b) {
    return (ty_window){larger(a.x0, b.x0), larger(a.y0, b.y0), smaller(a.x1, b.x1), smaller(a.y1, b.y1)};
}

size_t ty_image_index(const ty_image* image, int32_t x, int32_t y) {
    return (size_t)(y - image->frame[1]) * (size_t)image->width + (size_t)(x - image->frame[0]);
}

ty_result ty_image_create_full_frame(ty_context* context, const ty_image* image, ty_image** out) {
    if (image == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_create_full_frame: an argument is NULL");
    ty_image* filled = NULL;
    const ty_result result = ty_image_create_like(context, image, image->frame[2], image->frame[3], &filled);
    if (result != TY_OK) return result;
    const ty_window overlap = ty_window_intersection(ty_image_window(image), ty_image_window(filled));
    for (int32_t c = 0; c < image->channel_count && overlap.x0 < overlap.x1; ++c)
        for (int32_t y = overlap.y0; y < overlap.y1; ++y)
            memcpy(ty_image_plane(filled, c) + ty_image_index(filled, overlap.x0, y),
                   ty_image_plane_const(image, c) + ty_image_index(image, overlap.x0, y),
                   (size_t)(overlap.x1 - overlap.x0) * sizeof(float));
    *out = filled;
    return TY_OK;
}
