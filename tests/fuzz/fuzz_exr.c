/* OpenEXR images from memory. */
#include "fuzz_target.h"

#include "io/images/image_file.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_image* image = NULL;
    if (ty_read_exr(context, "fuzz.exr", bytes, size, &image) == TY_OK) ty_image_destroy(image);
    fuzz_finish(context, &used);
    return 0;
}
