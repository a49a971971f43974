/* Pictures: 8-bit sRGB pixels, from images at an exposure or from numbers by a color map. */
#ifndef TY_PLOT_PICTURE_H
#define TY_PLOT_PICTURE_H

#include "plot/color.h"

#include <tyndall/image.h>

typedef struct plot_picture {
    int32_t width, height;
    uint8_t* rgb8; /* width * height * 3, rows from the top; NULL: none */
} plot_picture;

/* The range of a color map. */
typedef struct plot_scale {
    plot_map map;
    double lower, upper;
    const char* label; /* label with the unit */
} plot_scale;

void plot_free_picture(plot_picture* picture);

/* An image's R, G and B, tone mapped by ty_image_tonemap with the filmic curve. Errors: TY_ERROR_ARGUMENT (no RGB),
 * TY_ERROR_MEMORY. */
ty_result plot_picture_of_image(ty_context* context, const ty_image* image, double exposure, plot_picture* out);
/* width * height numbers in false colors. Errors: TY_ERROR_MEMORY. */
ty_result plot_picture_of_values(ty_context* context, const float* values, int32_t width, int32_t height,
                                 const plot_scale* scale, plot_picture* out);
/* A rectangle of a picture, which must lie inside. Errors: TY_ERROR_MEMORY. */
ty_result plot_picture_crop(const plot_picture* picture, const int32_t rectangle[4], plot_picture* out);

#endif
