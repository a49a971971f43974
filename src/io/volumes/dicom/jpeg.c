/* JPEG frames (baseline, extended and lossless), by the precision that their frame header tells. */
#include "io/volumes/dicom/codec.h"

#include "base/context.h"

ty_result ty_dicom_wrong_frame(const ty_dicom_packed* frame, int64_t columns, int64_t rows, int64_t components,
                               int64_t bits) {
    return ty_fail(frame->context, TY_ERROR_INPUT,
                   "%s: a compressed frame of %lld x %lld pixels of %lld samples of %lld bits, where the elements tell "
                   "of %d x %d pixels of one sample of at most %zu bits",
                   frame->path, (long long)columns, (long long)rows, (long long)components, (long long)bits,
                   frame->columns, frame->rows, 8 * frame->sample_size);
}

#if TYNDALL_DICOM_JPEG

/* Precision of the samples by the frame header (T.81 section B.2.2), 0 without one. */
static int find_precision(const uint8_t* bytes, size_t size) {
    enum { SOF_FIRST = 0xc0, SOF_LAST = 0xcf, DHT = 0xc4, JPG = 0xc8, DAC = 0xcc };
    size_t at = 2;
    while (at + 4 < size && bytes[at] == 0xff) {
        const int marker = bytes[at + 1];
        if (marker == 0xff) {
            ++at;
            continue;
        }
        if (marker >= SOF_FIRST && marker <= SOF_LAST && marker != DHT && marker != JPG && marker != DAC)
            return bytes[at + 4];
        at += 2 + ((size_t)bytes[at + 2] << 8 | bytes[at + 3]);
    }
    return 0;
}

ty_result ty_dicom_decode_jpeg(const ty_dicom_packed* frame, uint8_t* out) {
    const int precision = find_precision(frame->bytes, frame->size);
    if (precision < 2 || precision > 16)
        return ty_fail(frame->context, TY_ERROR_INPUT, "%s: cannot decode this JPEG frame: it has no frame header",
                       frame->path);
    if (precision <= 8) return ty_dicom_decode_jpeg8(frame, out);
    return precision <= 12 ? ty_dicom_decode_jpeg12(frame, out) : ty_dicom_decode_jpeg16(frame, out);
}

#else

ty_result ty_dicom_decode_jpeg(const ty_dicom_packed* frame, uint8_t* out) {
    (void)out;
    return ty_fail(frame->context, TY_ERROR_INPUT,
                   "%s: compressed by JPEG, which this build was made without; \"gdcmconv --raw\" decompresses it",
                   frame->path);
}

#endif
