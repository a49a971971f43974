/* JPEG-LS frames through CharLS. */
#include "io/volumes/dicom/codec.h"

#include "base/context.h"

#if TYNDALL_CHARLS

#include <charls/charls.h>

static charls_jpegls_errc decode(const ty_dicom_packed* frame, charls_jpegls_decoder* decoder, uint8_t* out,
                                 bool* other) {
    const size_t size = (size_t)frame->columns * (size_t)frame->rows * frame->sample_size;
    charls_frame_info info = {0};
    charls_jpegls_errc error = charls_jpegls_decoder_set_source_buffer(decoder, frame->bytes, frame->size);
    if (error == 0) error = charls_jpegls_decoder_read_header(decoder);
    if (error == 0) error = charls_jpegls_decoder_get_frame_info(decoder, &info);
    if (error != 0) return error;
    const size_t sample_size = info.bits_per_sample > 8 ? 2 : 1;
    *other = info.width != (uint32_t)frame->columns || info.height != (uint32_t)frame->rows ||
             info.component_count != 1 || sample_size > frame->sample_size;
    if (*other) {
        ty_dicom_wrong_frame(frame, info.width, info.height, info.component_count, info.bits_per_sample);
        return error;
    }
    error = charls_jpegls_decoder_decode_to_buffer(decoder, out, size, 0);
    if (error == 0 && sample_size < frame->sample_size) /* spread the bytes over words, from the end */
        for (size_t i = size / 2; i-- > 0;) ((uint16_t*)(void*)out)[i] = out[i];
    return error;
}

ty_result ty_dicom_decode_jpeg_ls(const ty_dicom_packed* frame, uint8_t* out) {
    bool other = false;
    if (frame->sample_size > 2)
        return ty_fail(frame->context, TY_ERROR_INPUT, "%s: JPEG-LS has no samples of more than 16 bits", frame->path);
    charls_jpegls_decoder* decoder = charls_jpegls_decoder_create();
    if (decoder == NULL)
        return ty_fail(frame->context, TY_ERROR_MEMORY, "%s: not enough memory to decode JPEG-LS", frame->path);
    const charls_jpegls_errc error = decode(frame, decoder, out, &other);
    charls_jpegls_decoder_destroy(decoder);
    if (other) return TY_ERROR_INPUT;
    if (error == 0) return TY_OK;
    return ty_fail(frame->context, TY_ERROR_INPUT, "%s: cannot decode this JPEG-LS frame: %s", frame->path,
                   charls_get_error_message(error));
}

#else

ty_result ty_dicom_decode_jpeg_ls(const ty_dicom_packed* frame, uint8_t* out) {
    (void)out;
    return ty_fail(frame->context, TY_ERROR_INPUT,
                   "%s: compressed by JPEG-LS, which this build was made without; \"gdcmconv --raw\" decompresses it",
                   frame->path);
}

#endif
