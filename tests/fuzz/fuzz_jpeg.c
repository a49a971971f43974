/* JPEG images from memory, as images and as textures. */
#include "fuzz_image.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    fuzz_read_samples(context, ty_read_jpeg, "fuzz.jpeg", bytes, size);
    fuzz_finish(context, &used);
    return 0;
}
