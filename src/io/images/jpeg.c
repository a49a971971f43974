/* Reading JPEG through libjpeg. Corruption that libjpeg only warns of is an error, so that no file is read
 * partially. */
#include "io/images/image_file.h"

#include "base/context.h"

#include <setjmp.h>
#include <stdio.h>
#include <string.h>

#include <jpeglib.h>
#include <jerror.h>

/* Progressive files have about ten scans. The limit exists because each scan processes all pixels, even one of a few
 * bytes. */
enum { SCANS_MAX = 128 };

typedef struct reader {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_progress_mgr progress;
    jmp_buf jump;
    char message[JMSG_LENGTH_MAX];
} reader;

static void handle_error(j_common_ptr jpeg) {
    reader* r = jpeg->client_data;
    jpeg->err->format_message(jpeg, r->message);
    longjmp(r->jump, 1);
}

/* level is -1 for a warning. The three warnings below leave the pixels intact. */
static void handle_message(j_common_ptr jpeg, int level) {
    const int code = jpeg->err->msg_code;
    if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_ADOBE_XFORM && code != JWRN_JFIF_MAJOR)
        handle_error(jpeg);
}

static void limit_scans(j_common_ptr jpeg) {
    reader* r = jpeg->client_data;
    if (r->jpeg.input_scan_number <= SCANS_MAX) return;
    snprintf(r->message, sizeof r->message, "more than %d scans", (int)SCANS_MAX);
    longjmp(r->jump, 1);
}

/* libjpeg leaves by longjmp: no local variable changes between setjmp and longjmp, here and below. */
static bool read_header(reader* r, const uint8_t* bytes, size_t size) {
    r->jpeg.err = jpeg_std_error(&r->errors);
    r->errors.error_exit = handle_error;
    r->errors.emit_message = handle_message;
    r->progress.progress_monitor = limit_scans;
    r->jpeg.client_data = r;
    if (setjmp(r->jump) != 0) return false;
    jpeg_create_decompress(&r->jpeg);
    r->jpeg.progress = &r->progress;
    jpeg_mem_src(&r->jpeg, bytes, (unsigned long)size);
    jpeg_read_header(&r->jpeg, TRUE);
    return true;
}

static bool read_rows(reader* r, const ty_samples* samples) {
    if (setjmp(r->jump) != 0) return false;
    jpeg_start_decompress(&r->jpeg);
    const size_t stride = (size_t)samples->width * (size_t)samples->channels;
    while (r->jpeg.output_scanline < r->jpeg.output_height) {
        JSAMPROW row = (JSAMPROW)samples->data + stride * r->jpeg.output_scanline;
        jpeg_read_scanlines(&r->jpeg, &row, 1);
    }
    jpeg_finish_decompress(&r->jpeg);
    return true;
}

/* In place, without a profile: each color is its ink's transmittance times black's. Adobe's files store 255 minus
 * ink. */
static void rgb_from_cmyk(ty_samples* samples, bool inverted) {
    uint8_t* data = samples->data;
    for (size_t i = 0; i < (size_t)samples->width * (size_t)samples->height; ++i) {
        const uint8_t* cmyk = data + 4 * i;
        uint32_t light[4];
        for (size_t c = 0; c < 4; ++c) light[c] = inverted ? cmyk[c] : 255u - cmyk[c];
        for (size_t c = 0; c < 3; ++c) data[3 * i + c] = (uint8_t)((light[c] * light[3] + 127) / 255);
    }
    samples->channels = 3;
}

/* Output channels requested from libjpeg: 1 gray, 3 RGB or 4 CMYK; 0 if unsupported. */
static int32_t choose_channels(struct jpeg_decompress_struct* jpeg) {
    switch (jpeg->jpeg_color_space) {
    case JCS_GRAYSCALE: jpeg->out_color_space = JCS_GRAYSCALE; return 1;
    case JCS_RGB:
    case JCS_YCbCr: jpeg->out_color_space = JCS_RGB; return 3;
    case JCS_CMYK:
    case JCS_YCCK: jpeg->out_color_space = JCS_CMYK; return 4;
    default: return 0;
    }
}

static ty_result decode(ty_context* context, const char* path, reader* r, const uint8_t* bytes, size_t size,
                        ty_samples* out) {
    if (!read_header(r, bytes, size))
        return ty_fail(context, TY_ERROR_INPUT, "%s: cannot decode this JPEG: %s", path, r->message);
    const int32_t channels = choose_channels(&r->jpeg);
    if (channels == 0)
        return ty_fail(context, TY_ERROR_INPUT, "%s: a JPEG of %d components is neither gray, RGB nor CMYK", path,
                       r->jpeg.num_components);
    ty_result result = ty_check_image_size(context, path, size, r->jpeg.image_width, r->jpeg.image_height, channels);
    ty_samples samples;
    if (result == TY_OK)
        result = ty_create_samples(context, (int32_t)r->jpeg.image_width, (int32_t)r->jpeg.image_height, channels,
                                   false, &samples);
    if (result != TY_OK) return result;
    if (!read_rows(r, &samples)) {
        ty_free_samples(context, &samples);
        return ty_fail(context, TY_ERROR_INPUT, "%s: cannot decode this JPEG: %s", path, r->message);
    }
    if (channels == 4) rgb_from_cmyk(&samples, r->jpeg.saw_Adobe_marker);
    *out = samples;
    return TY_OK;
}

ty_result ty_read_jpeg(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_samples* out) {
    reader r = {0};
    const ty_result result = decode(context, path, &r, bytes, size, out);
    jpeg_destroy_decompress(&r.jpeg);
    return result;
}
