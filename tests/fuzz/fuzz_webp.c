/* WebP images from memory, as images and as textures. */
#include "fuzz_target.h"

#include "base/context.h"
#include "io/images/image_file.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_samples samples;
    if (ty_read_webp(context, "fuzz.webp", bytes, size, &samples) == TY_OK) {
        ty_image* image = NULL;
        if (ty_image_from_samples(context, &samples, TY_SAMPLES_LINEAR, &image) == TY_OK) ty_image_destroy(image);
        ty_free_samples(context, &samples);
    }
    int32_t width = 0, height = 0;
    uint8_t* rgba8 = NULL;
    if (ty_decode_rgba8(context, "fuzz.webp", bytes, size, &width, &height, &rgba8) == TY_OK)
        ty_free_array(context, rgba8, (size_t)width * (size_t)height, 4);
    fuzz_finish(context, &used);
    return 0;
}
