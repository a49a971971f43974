/* Encoders of frames of one size, for tests; 0 where the library is missing. */
#ifndef TY_TESTS_DICOM_ENCODERS_H
#define TY_TESTS_DICOM_ENCODERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { ENCODED_WIDTH = 16, ENCODED_HEIGHT = 12, ENCODED_PIXELS = ENCODED_WIDTH * ENCODED_HEIGHT };

/* Samples as bytes or words of the machine. */
static inline size_t pack_samples(const int64_t* samples, int bits, uint8_t* out) {
    for (int i = 0; i < ENCODED_PIXELS; ++i) {
        const uint16_t word = (uint16_t)samples[i];
        if (bits <= 8)
            out[i] = (uint8_t)word;
        else
            memcpy(out + 2 * i, &word, 2);
    }
    return ENCODED_PIXELS * (bits <= 8 ? 1 : 2);
}

/* Each row as a literal run, but rows of one value, and the first four samples after one another. */
static inline size_t encode_rle(const int64_t* samples, int bits, uint8_t* out, size_t size) {
    const uint32_t segments = bits <= 8 ? 1 : 2;
    size_t at = 64;
    if (size < at + segments * 2 * ENCODED_PIXELS) return 0;
    memset(out, 0, at);
    out[0] = (uint8_t)segments;
    for (uint32_t s = 0; s < segments; ++s) {
        const int shift = 8 * (int)(segments - 1 - s);
        out[4 + 4 * s] = (uint8_t)at;
        out[5 + 4 * s] = (uint8_t)(at >> 8);
        for (int i = 0; i < ENCODED_PIXELS;) {
            const uint8_t value = (uint8_t)(samples[i] >> shift);
            int run = 1;
            while (run < 128 && i + run < ENCODED_PIXELS && (uint8_t)(samples[i + run] >> shift) == value) ++run;
            out[at++] = (uint8_t)(run > 1 ? 257 - run : 0); /* a run, or one literal */
            out[at++] = value;
            i += run;
        }
        out[at++] = 128; /* no operation */
        if (at % 2 != 0) out[at++] = 128;
    }
    return at;
}

#if TYNDALL_CHARLS
#include <charls/charls.h>

static inline size_t encode_jpeg_ls(const int64_t* samples, int bits, uint8_t* out, size_t size) {
    uint8_t packed[2 * ENCODED_PIXELS];
    const size_t packed_size = pack_samples(samples, bits, packed);
    const charls_frame_info info = {ENCODED_WIDTH, ENCODED_HEIGHT, bits, 1};
    size_t written = 0;
    charls_jpegls_encoder* encoder = charls_jpegls_encoder_create();
    const bool good = charls_jpegls_encoder_set_frame_info(encoder, &info) == 0 &&
                      charls_jpegls_encoder_set_destination_buffer(encoder, out, size) == 0 &&
                      charls_jpegls_encoder_encode_from_buffer(encoder, packed, packed_size, 0) == 0 &&
                      charls_jpegls_encoder_get_bytes_written(encoder, &written) == 0;
    charls_jpegls_encoder_destroy(encoder);
    return good ? written : 0;
}
#else
static inline size_t encode_jpeg_ls(const int64_t* samples, int bits, uint8_t* out, size_t size) {
    (void)samples, (void)bits, (void)out, (void)size;
    return 0;
}
#endif

#if TYNDALL_OPENJPEG
#include <openjpeg.h>

typedef struct encoded_stream {
    uint8_t* out;
    size_t size, at, length;
} encoded_stream;

static inline OPJ_SIZE_T write_encoded(void* from, OPJ_SIZE_T count, void* user) {
    encoded_stream* s = user;
    if (count > s->size - s->at) return (OPJ_SIZE_T)-1;
    memcpy(s->out + s->at, from, count);
    s->at += count;
    if (s->at > s->length) s->length = s->at;
    return count;
}

static inline OPJ_OFF_T skip_encoded(OPJ_OFF_T count, void* user) {
    encoded_stream* s = user;
    s->at += (size_t)count;
    return count;
}

static inline OPJ_BOOL seek_encoded(OPJ_OFF_T offset, void* user) {
    encoded_stream* s = user;
    s->at = (size_t)offset;
    return OPJ_TRUE;
}

static inline size_t encode_jpeg_2000(const int64_t* samples, int bits, uint8_t* out, size_t size) {
    encoded_stream state = {.out = out, .size = size};
    opj_image_cmptparm_t component = {
        .dx = 1, .dy = 1, .w = ENCODED_WIDTH, .h = ENCODED_HEIGHT, .prec = (OPJ_UINT32)bits};
    opj_cparameters_t parameters;
    opj_set_default_encoder_parameters(&parameters);
    parameters.numresolution = 3;
    opj_image_t* image = opj_image_create(1, &component, OPJ_CLRSPC_GRAY);
    image->x1 = ENCODED_WIDTH;
    image->y1 = ENCODED_HEIGHT;
    for (int i = 0; i < ENCODED_PIXELS; ++i) image->comps[0].data[i] = (OPJ_INT32)samples[i];
    opj_codec_t* codec = opj_create_compress(OPJ_CODEC_J2K);
    opj_stream_t* stream = opj_stream_default_create(OPJ_FALSE);
    opj_stream_set_write_function(stream, write_encoded);
    opj_stream_set_skip_function(stream, skip_encoded);
    opj_stream_set_seek_function(stream, seek_encoded);
    opj_stream_set_user_data(stream, &state, NULL);
    const bool good = opj_setup_encoder(codec, &parameters, image) && opj_start_compress(codec, image, stream) &&
                      opj_encode(codec, stream) && opj_end_compress(codec, stream);
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
    opj_image_destroy(image);
    return good ? state.length : 0;
}
#else
static inline size_t encode_jpeg_2000(const int64_t* samples, int bits, uint8_t* out, size_t size) {
    (void)samples, (void)bits, (void)out, (void)size;
    return 0;
}
#endif

/* jpeg_encoder.c, built for each precision. */
size_t encode_jpeg8(const int64_t* samples, bool lossless, uint8_t* out, size_t size);
size_t encode_jpeg12(const int64_t* samples, bool lossless, uint8_t* out, size_t size);
size_t encode_jpeg16(const int64_t* samples, bool lossless, uint8_t* out, size_t size);

#define DEFINE_JPEG_ENCODER(name, encoder, lossless)                                                                   \
    static inline size_t name(const int64_t* samples, int bits, uint8_t* out, size_t size) {                           \
        (void)bits;                                                                                                    \
        return TYNDALL_DICOM_JPEG ? encoder(samples, lossless, out, size) : 0;                                         \
    }
DEFINE_JPEG_ENCODER(encode_jpeg_lossless8, encode_jpeg8, true)
DEFINE_JPEG_ENCODER(encode_jpeg_lossless12, encode_jpeg12, true)
DEFINE_JPEG_ENCODER(encode_jpeg_lossless16, encode_jpeg16, true)
DEFINE_JPEG_ENCODER(encode_jpeg_lossy8, encode_jpeg8, false)
DEFINE_JPEG_ENCODER(encode_jpeg_lossy12, encode_jpeg12, false)

#endif
