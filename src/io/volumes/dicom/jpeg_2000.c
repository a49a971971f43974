/* JPEG 2000 frames through OpenJPEG. */
#include "io/volumes/dicom/codec.h"

#include "base/context.h"

#if TYNDALL_OPENJPEG

#include <openjpeg.h>
#include <string.h>

/* Bytes in memory as a stream, and the library's first message. */
typedef struct stream_state {
    const ty_dicom_packed* frame;
    size_t at;
    char message[160];
} stream_state;

static OPJ_SIZE_T read_bytes(void* to, OPJ_SIZE_T wanted, void* user) {
    stream_state* s = user;
    const size_t left = s->frame->size - s->at, size = wanted < left ? wanted : left;
    if (size == 0) return (OPJ_SIZE_T)-1;
    memcpy(to, s->frame->bytes + s->at, size);
    s->at += size;
    return size;
}

static OPJ_BOOL seek_bytes(OPJ_OFF_T offset, void* user) {
    stream_state* s = user;
    if (offset < 0 || (size_t)offset > s->frame->size) return OPJ_FALSE;
    s->at = (size_t)offset;
    return OPJ_TRUE;
}

static OPJ_OFF_T skip_bytes(OPJ_OFF_T count, void* user) {
    stream_state* s = user;
    return count >= 0 && seek_bytes((OPJ_OFF_T)s->at + count, user) == OPJ_TRUE ? count : -1;
}

static void take_error(const char* text, void* user) {
    stream_state* s = user;
    if (s->message[0] != '\0') return;
    snprintf(s->message, sizeof s->message, "%.*s", (int)strcspn(text, "\r\n"), text);
}

static void ignore_text(const char* text, void* user) {
    (void)text;
    (void)user;
}

static bool is_expected(const ty_dicom_packed* frame, const opj_image_t* image) {
    const opj_image_comp_t* c = image->comps;
    return image->numcomps == 1 && c->dx == 1 && c->dy == 1 && image->x1 - image->x0 == (OPJ_UINT32)frame->columns &&
           image->y1 - image->y0 == (OPJ_UINT32)frame->rows && c->prec <= 8 * frame->sample_size;
}

static void copy_samples(const ty_dicom_packed* frame, const opj_image_comp_t* component, uint8_t* out) {
    const size_t pixels = (size_t)frame->columns * (size_t)frame->rows;
    for (size_t i = 0; i < pixels; ++i)
        if (frame->sample_size == 1)
            out[i] = (uint8_t)component->data[i];
        else
            ((uint16_t*)(void*)out)[i] = (uint16_t)component->data[i];
}

static ty_result decode(const ty_dicom_packed* frame, opj_codec_t* codec, opj_stream_t* stream, stream_state* state,
                        uint8_t* out) {
    opj_dparameters_t parameters;
    opj_image_t* image = NULL;
    opj_set_default_decoder_parameters(&parameters);
    opj_set_error_handler(codec, take_error, state);
    opj_set_warning_handler(codec, ignore_text, NULL);
    opj_set_info_handler(codec, ignore_text, NULL);
    bool good = opj_setup_decoder(codec, &parameters) && opj_read_header(stream, codec, &image);
    ty_result result = TY_OK;
    if (good && !is_expected(frame, image)) {
        result = ty_dicom_wrong_frame(frame, (int64_t)image->x1 - image->x0, (int64_t)image->y1 - image->y0,
                                      image->numcomps, image->numcomps > 0 ? image->comps->prec : 0);
    } else {
        good = good && opj_decode(codec, stream, image) && image->comps->data != NULL &&
               image->comps->w == (OPJ_UINT32)frame->columns && image->comps->h == (OPJ_UINT32)frame->rows;
        if (good)
            copy_samples(frame, image->comps, out);
        else
            result = ty_fail(frame->context, TY_ERROR_INPUT, "%s: cannot decode this JPEG 2000 frame: %s", frame->path,
                             state->message[0] != '\0' ? state->message : "it is damaged");
    }
    opj_image_destroy(image);
    return result;
}

ty_result ty_dicom_decode_jpeg_2000(const ty_dicom_packed* frame, uint8_t* out) {
    stream_state state = {.frame = frame};
    const bool boxes = frame->size >= 12 && memcmp(frame->bytes + 4, "jP  ", 4) == 0;
    opj_codec_t* codec = opj_create_decompress(boxes ? OPJ_CODEC_JP2 : OPJ_CODEC_J2K);
    opj_stream_t* stream = opj_stream_default_create(OPJ_TRUE);
    ty_result result = TY_ERROR_MEMORY;
    if (frame->sample_size > 2) {
        result = ty_fail(frame->context, TY_ERROR_INPUT, "%s: JPEG 2000 samples of more than 16 bits", frame->path);
    } else if (codec == NULL || stream == NULL) {
        ty_fail(frame->context, result, "%s: not enough memory to decode JPEG 2000", frame->path);
    } else {
        opj_stream_set_read_function(stream, read_bytes);
        opj_stream_set_seek_function(stream, seek_bytes);
        opj_stream_set_skip_function(stream, skip_bytes);
        opj_stream_set_user_data(stream, &state, NULL);
        opj_stream_set_user_data_length(stream, frame->size);
        result = decode(frame, codec, stream, &state, out);
    }
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
    return result;
}

#else

ty_result ty_dicom_decode_jpeg_2000(const ty_dicom_packed* frame, uint8_t* out) {
    (void)out;
    return ty_fail(frame->context, TY_ERROR_INPUT,
                   "%s: compressed by JPEG 2000, which this build was made without; \"gdcmconv --raw\" decompresses it",
                   frame->path);
}

#endif
