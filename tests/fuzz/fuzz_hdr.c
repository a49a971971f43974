/* Radiance .hdr images from memory. */
#include "fuzz_image.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_read_image(ty_read_hdr, "fuzz.hdr", bytes, size);
}
