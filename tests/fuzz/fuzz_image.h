/* Shared by the fuzz targets of images. */
#ifndef TY_TESTS_FUZZ_IMAGE_H
#define TY_TESTS_FUZZ_IMAGE_H

#include "fuzz_target.h"

#include "base/context.h"
#include "io/images/image_file.h"

typedef ty_result fuzz_image_reader(ty_context* context, const char* name, const uint8_t* bytes, size_t size,
                                    ty_image** image);
typedef ty_result fuzz_samples_reader(ty_context* context, const char* name, const uint8_t* bytes, size_t size,
                                      ty_samples* samples);

/* Reads bytes as an image. */
static inline int fuzz_read_image(fuzz_image_reader* read, const char* name, const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_image* image = NULL;
    if (read(context, name, bytes, size, &image) == TY_OK) ty_image_destroy(image);
    fuzz_finish(context, &used);
    return 0;
}

/* Reads bytes as samples of an image, and as a texture. */
static inline void fuzz_read_samples(ty_context* context, fuzz_samples_reader* read, const char* name,
                                     const uint8_t* bytes, size_t size) {
    ty_samples samples;
    if (read(context, name, bytes, size, &samples) == TY_OK) {
        ty_image* image = NULL;
        if (ty_image_from_samples(context, &samples, TY_SAMPLES_LINEAR, &image) == TY_OK) ty_image_destroy(image);
        ty_free_samples(context, &samples);
    }
    int32_t width = 0, height = 0;
    uint8_t* rgba8 = NULL;
    if (ty_decode_rgba8(context, name, bytes, size, &width, &height, &rgba8) == TY_OK)
        ty_free_array(context, rgba8, (size_t)width * (size_t)height, 4);
}

#endif
