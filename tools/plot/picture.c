/* Conversion of images and numbers to pictures. */
#include "plot/picture.h"

#include <stdlib.h>
#include <string.h>

void plot_free_picture(plot_picture* picture) {
    free(picture->rgb8);
    *picture = (plot_picture){0};
}

static ty_result create_picture(int32_t width, int32_t height, plot_picture* out) {
    uint8_t* rgb8 = calloc((size_t)width * (size_t)height, 3);
    if (rgb8 == NULL) return TY_ERROR_MEMORY;
    *out = (plot_picture){width, height, rgb8};
    return TY_OK;
}

static ty_result show(ty_context* context, const ty_image* image, double exposure, ty_tone_curve curve,
                      plot_picture* out) {
    plot_picture picture;
    ty_result result = create_picture(ty_image_width(image), ty_image_height(image), &picture);
    if (result != TY_OK) return result;
    result = ty_image_tonemap(context, image, exposure, curve, picture.rgb8);
    if (result != TY_OK) {
        plot_free_picture(&picture);
        return result;
    }
    *out = picture;
    return TY_OK;
}

ty_result plot_picture_of_image(ty_context* context, const ty_image* image, double exposure, plot_picture* out) {
    return show(context, image, exposure, TY_TONE_FILMIC, out);
}

ty_result plot_picture_of_values(ty_context* context, const float* values, int32_t width, int32_t height,
                                 const plot_scale* scale, plot_picture* out) {
    ty_image* colors = NULL;
    ty_result result = ty_image_create_rgb(context, width, height, &colors);
    if (result != TY_OK) return result;
    float* planes[3];
    for (int c = 0; c < 3; ++c) planes[c] = ty_image_plane(colors, c);
    for (size_t i = 0; i < (size_t)width * (size_t)height; ++i) {
        float rgb[3];
        plot_map_color(scale->map, ((double)values[i] - scale->lower) / (scale->upper - scale->lower), rgb);
        for (int c = 0; c < 3; ++c) planes[c][i] = rgb[c];
    }
    result = show(context, colors, 0, TY_TONE_CLIP, out);
    ty_image_destroy(colors);
    return result;
}

ty_result plot_picture_crop(const plot_picture* picture, const int32_t rectangle[4], plot_picture* out) {
    const ty_result result = create_picture(rectangle[2], rectangle[3], out);
    if (result != TY_OK) return result;
    const size_t row = 3 * (size_t)rectangle[2];
    for (int32_t y = 0; y < rectangle[3]; ++y) {
        const size_t from = ((size_t)(rectangle[1] + y) * (size_t)picture->width + (size_t)rectangle[0]) * 3;
        memcpy(out->rgb8 + (size_t)y * row, picture->rgb8 + from, row);
    }
    return TY_OK;
}
