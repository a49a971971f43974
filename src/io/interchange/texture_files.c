#include "io/interchange/texture_files.h"

#include "base/context.h"
#include "io/volumes/volume_file.h"

#include <math.h>
#include <string.h>

static bool has_extension(const char* name, const char* const* extensions) {
    for (; *extensions != NULL; ++extensions)
        if (ty_volume_has_extension(name, *extensions)) return true;
    return false;
}

static float encode(float value, const ty_texture_reading* reading) {
    if (reading->inverted) value = 1 - value;
    value = fminf(fmaxf(value, 0), 1);
    return reading->exponent > 0 ? (float)pow((double)value, reading->exponent) : value;
}

/* An RGB image of the samples: of numbers, the first channel three times. */
static ty_result rewrite(ty_conversion* conversion, const ty_image* image, const ty_texture_reading* reading,
                         char** reference) {
    const float* planes[3];
    if (reading->exponent > 0 || !ty_image_rgb_planes(image, planes))
        for (int c = 0; c < 3; ++c) planes[c] = ty_image_plane_const(image, 0);
    ty_image* made = NULL;
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    ty_result result = ty_image_create_rgb(conversion->context, width, height, &made);
    if (result != TY_OK) return result;
    bool clipped = false;
    for (int32_t c = 0; c < 3; ++c) {
        float* to = ty_image_plane(made, c);
        for (size_t i = 0; i < (size_t)width * (size_t)height; ++i) {
            clipped = clipped || planes[c][i] > 1;
            to[i] = encode(planes[c][i], reading);
        }
    }
    if (clipped) ty_conversion_approximate(conversion, "a texture's values above 1 were clipped");
    result = ty_conversion_write_png(conversion, made, reading->exponent > 0, reference);
    ty_image_destroy(made);
    return result;
}

ty_result ty_convert_texture(ty_conversion* conversion, const char* location, const char* name,
                             const ty_texture_reading* reading, char** reference) {
    static const char* const plain[] = {".png", ".jpg", ".jpeg", ".webp", NULL};
    static const char* const readable[] = {".png", ".jpg", ".jpeg", ".exr", ".hdr", NULL};
    char* path = NULL;
    *reference = NULL;
    ty_result result = ty_conversion_find_file(conversion, location, name, &path, reference);
    if (result != TY_OK || path == NULL) return result;
    const bool as_it_is = !reading->linear && !reading->inverted && reading->exponent == 0;
    if (as_it_is && has_extension(name, plain)) {
        ty_free_text(conversion->context, path);
        return TY_OK;
    }
    ty_free_text(conversion->context, *reference);
    *reference = NULL;
    if (has_extension(name, readable)) {
        ty_image* image = NULL;
        result = reading->linear ? ty_image_read_raw(conversion->context, path, &image)
                                 : ty_image_read(conversion->context, path, &image);
        if (result == TY_OK) result = rewrite(conversion, image, reading, reference);
        ty_image_destroy(image);
    } else {
        ty_conversion_leave_out(conversion, "the texture \"%.200s\", whose format is not read", name);
    }
    ty_free_text(conversion->context, path);
    return result;
}
