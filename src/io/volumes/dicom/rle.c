/* RLE of DICOM (PS3.5 annex G): a segment of PackBits for each byte of a sample, the most significant first. */
#include "io/volumes/dicom/codec.h"

#include "base/context.h"

#include <string.h>

enum { SEGMENTS_MAX = 15, HEADER_SIZE = 4 * (1 + SEGMENTS_MAX) };

static uint32_t word_at(const uint8_t* bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* Unpacks a segment into every step-th byte; false if it ends before `count` of them. */
static bool unpack(const uint8_t* from, const uint8_t* end, uint8_t* to, size_t step, size_t count) {
    size_t done = 0;
    while (done < count && end - from >= 2) {
        const int code = *from < 128 ? *from : *from - 256; /* a signed byte */
        ++from;
        if (code == -128) continue;
        const size_t wanted = (size_t)(code >= 0 ? code + 1 : 1 - code), left = count - done;
        const size_t length = wanted < left ? wanted : left;
        if (code >= 0 && (size_t)(end - from) < length) return false;
        for (size_t i = 0; i < length; ++i) to[step * (done + i)] = code >= 0 ? from[i] : from[0];
        from += code >= 0 ? length : 1;
        done += length;
    }
    return done == count;
}

ty_result ty_dicom_decode_rle(const ty_dicom_packed* frame, uint8_t* out) {
    const size_t pixels = (size_t)frame->columns * (size_t)frame->rows, bytes = frame->sample_size;
    bool good = frame->size >= HEADER_SIZE && word_at(frame->bytes) == bytes;
    for (size_t s = 0; s < bytes && good; ++s) {
        const uint32_t start = word_at(frame->bytes + 4 * (1 + s));
        const uint32_t stop = s + 1 < bytes ? word_at(frame->bytes + 4 * (2 + s)) : (uint32_t)frame->size;
        const size_t place = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__ ? s : bytes - 1 - s;
        good = start >= HEADER_SIZE && start <= stop && stop <= frame->size &&
               unpack(frame->bytes + start, frame->bytes + stop, out + place, bytes, pixels);
    }
    if (good) return TY_OK;
    return ty_fail(frame->context, TY_ERROR_INPUT, "%s: cannot decode this RLE frame: it is damaged or cut short",
                   frame->path);
}
