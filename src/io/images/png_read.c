/* Reading PNG: every color type and bit depth, expanded to 8 or 16 bits per sample. */
#include "io/images/image_file.h"

#include "base/context.h"

#include <png.h>
#include <setjmp.h>
#include <string.h>

/* 8-byte signature, then the IHDR chunk: length, name, width, height, 5 more bytes, checksum. */
enum { MESSAGE_SIZE = 128, NAME_AT = 12, WIDTH_AT = 16, HEIGHT_AT = 20, HEADER_SIZE = 33 };

typedef struct reader {
    const uint8_t* at;
    size_t left;
    png_structp png;
    png_infop info;
    char message[MESSAGE_SIZE];
} reader;

static void store_message(png_structp png, png_const_charp text) {
    reader* r = png_get_error_ptr(png);
    strncpy(r->message, text, MESSAGE_SIZE - 1);
    longjmp(png_jmpbuf(png), 1);
}

static void ignore_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

static void read_bytes(png_structp png, png_bytep to, size_t count) {
    reader* r = png_get_io_ptr(png);
    if (count > r->left) png_error(png, "the file is cut short");
    memcpy(to, r->at, count);
    r->at += count;
    r->left -= count;
}

/* libpng leaves by longjmp: no local variable changes between setjmp and longjmp, here and below. */
static bool read_header(reader* r) {
    if (setjmp(png_jmpbuf(r->png)) != 0) return false;
    png_set_read_fn(r->png, r, read_bytes);
    png_set_user_limits(r->png, TY_IMAGE_SIDE_MAX, TY_IMAGE_SIDE_MAX);
    png_set_crc_action(r->png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_read_info(r->png, r->info);
    png_set_expand(r->png); /* palettes to RGB, low bit depths to 8, a transparent color to alpha */
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    png_set_swap(r->png);
#endif
    png_set_interlace_handling(r->png);
    png_read_update_info(r->png, r->info);
    return true;
}

static bool read_rows(reader* r, const ty_samples* samples) {
    if (setjmp(png_jmpbuf(r->png)) != 0) return false;
    const size_t stride = png_get_rowbytes(r->png, r->info);
    const int passes = png_get_interlace_type(r->png, r->info) == PNG_INTERLACE_ADAM7 ? PNG_INTERLACE_ADAM7_PASSES : 1;
    for (int pass = 0; pass < passes; ++pass)
        for (size_t y = 0; y < (size_t)samples->height; ++y)
            png_read_row(r->png, (png_bytep)samples->data + y * stride, NULL);
    png_read_end(r->png, NULL);
    return true;
}

static ty_result decode(ty_context* context, const char* path, size_t size, reader* r, ty_samples* out) {
    if (!read_header(r)) return ty_fail(context, TY_ERROR_INPUT, "%s: cannot decode this PNG: %s", path, r->message);
    const int32_t width = (int32_t)png_get_image_width(r->png, r->info);
    const int32_t height = (int32_t)png_get_image_height(r->png, r->info);
    const int32_t channels = png_get_channels(r->png, r->info);
    ty_samples samples;
    ty_result result = ty_check_image_size(context, path, size, width, height, channels);
    if (result == TY_OK)
        result =
            ty_create_samples(context, width, height, channels, png_get_bit_depth(r->png, r->info) == 16, &samples);
    if (result != TY_OK) return result;
    if (!read_rows(r, &samples)) {
        ty_free_samples(context, &samples);
        return ty_fail(context, TY_ERROR_INPUT, "%s: cannot decode this PNG: %s", path, r->message);
    }
    *out = samples;
    return TY_OK;
}

static int64_t big_endian(const uint8_t* bytes) {
    return (int64_t)bytes[0] << 24 | bytes[1] << 16 | bytes[2] << 8 | bytes[3];
}

ty_result ty_read_png(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_samples* out) {
    if (size < HEADER_SIZE || memcmp(bytes + NAME_AT, "IHDR", 4) != 0)
        return ty_fail(context, TY_ERROR_INPUT, "%s: the PNG header is damaged or cut short", path);
    /* A size check before libpng allocates rows, while the number of channels is unknown. */
    ty_result result =
        ty_check_image_size(context, path, size, big_endian(bytes + WIDTH_AT), big_endian(bytes + HEIGHT_AT), 1);
    if (result != TY_OK) return result;
    reader r = {.at = bytes, .left = size};
    r.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &r, store_message, ignore_warning);
    r.info = r.png == NULL ? NULL : png_create_info_struct(r.png);
    result = r.info == NULL ? ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory for libpng", path)
                            : decode(context, path, size, &r, out);
    png_destroy_read_struct(&r.png, &r.info, NULL);
    return result;
}
