/* PNG images from memory, as images and as textures, as they are and with the checksums that they should have: mutated
 * ones are hardly ever right, and libpng would look no further. */
#include "fuzz_image.h"

#include <string.h>

#include <zlib.h>

static void read_all(ty_context* context, const uint8_t* bytes, size_t size) {
    fuzz_read_samples(context, ty_read_png, "fuzz.png", bytes, size);
}

/* Chunks are a length, a name, so many bytes and a checksum over name and bytes; numbers are big-endian. */
static void mend_checksums(uint8_t* bytes, size_t size) {
    for (size_t at = 8; at + 12 <= size;) {
        const size_t length =
            (size_t)bytes[at] << 24 | (size_t)bytes[at + 1] << 16 | (size_t)bytes[at + 2] << 8 | (size_t)bytes[at + 3];
        if (length > size - at - 12) return;
        const uLong sum = crc32(0, bytes + at + 4, (uInt)length + 4);
        for (size_t i = 0; i < 4; ++i) bytes[at + 8 + length + i] = (uint8_t)(sum >> (24 - 8 * i));
        at += length + 12;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    read_all(context, bytes, size);
    uint8_t* mended = malloc(size + 1);
    if (mended == NULL) abort();
    if (size > 0) memcpy(mended, bytes, size);
    mend_checksums(mended, size);
    read_all(context, mended, size);
    free(mended);
    fuzz_finish(context, &used);
    return 0;
}
