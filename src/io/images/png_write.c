/* Writing PNG: 8-bit sRGB, 16-bit gray, and texels of four bytes. */
#include "base/context.h"
#include "io/file.h"
#include "io/images/image_file.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <string.h>
#include <tyndall/io.h>

enum { MESSAGE_SIZE = 128 };

static void store_message(png_structp png, png_const_charp text) {
    char* message = png_get_error_ptr(png);
    strncpy(message, text, MESSAGE_SIZE - 1);
    longjmp(png_jmpbuf(png), 1);
}

static void ignore_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

/* The commit reports a failed write; the text here is never seen. */
static void write_bytes(png_structp png, png_bytep bytes, size_t size) {
    if (!ty_output_write(png_get_io_ptr(png), bytes, size)) png_error(png, "write error");
}

/* ty_output writes back by itself. */
static void flush_nothing(png_structp png) {
    (void)png;
}

/* Rows without padding. */
typedef struct raster {
    const void* rows;
    size_t stride; /* bytes */
    uint32_t width, height;
    int depth, colour; /* libpng's constants; 8-bit RGB is sRGB, all else are linear numbers */
    char* range;       /* of RGBM, as a text of the file; NULL: none */
} raster;

/* libpng leaves by longjmp: no variable here changes between setjmp and longjmp. */
static bool encode(png_structp png, png_infop info, ty_output* output, const raster* image) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_write_fn(png, output, write_bytes, flush_nothing);
    png_set_IHDR(png, info, image->width, image->height, image->depth, image->colour, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (image->colour == PNG_COLOR_TYPE_RGB) png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (image->range != NULL) {
        char key[] = "rgbm_range";
        const png_text text = {.compression = PNG_TEXT_COMPRESSION_NONE, .key = key, .text = image->range};
        png_set_text(png, info, &text, 1);
    }
    png_write_info(png, info);
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    if (image->depth == 16) png_set_swap(png);
#endif
    for (uint32_t y = 0; y < image->height; ++y)
        png_write_row(png, (png_const_bytep)image->rows + (size_t)y * image->stride);
    png_write_end(png, info);
    return true;
}

static ty_result write_png(ty_context* context, const raster* image, const char* path) {
    char message[MESSAGE_SIZE] = "";
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, message, store_message, ignore_warning);
    png_infop info = png == NULL ? NULL : png_create_info_struct(png);
    ty_output output;
    ty_result result = info == NULL ? ty_fail(context, TY_ERROR_MEMORY, "not enough memory to write %s", path) : TY_OK;
    if (result == TY_OK) result = ty_output_open(context, path, &output);
    if (result == TY_OK) {
        if (encode(png, info, &output, image) || output.error != 0) {
            result = ty_output_commit(context, &output);
        } else {
            ty_output_discard(context, &output);
            result = ty_fail(context, TY_ERROR_FILE, "cannot write %s: %s", path, message);
        }
    }
    png_destroy_write_struct(&png, &info);
    return result;
}

ty_result ty_image_write_png(ty_context* context, const ty_image* image, double exposure, ty_tone_curve curve,
                             const char* path) {
    if (image == NULL || path == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_write_png: an argument is NULL");
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const size_t pixels = (size_t)width * (size_t)height;
    uint8_t* rgb8 = ty_alloc_array(context, pixels, 3, false);
    if (rgb8 == NULL) return TY_ERROR_MEMORY;
    ty_result result = ty_image_tonemap(context, image, exposure, curve, rgb8);
    const raster image8 = {rgb8, (size_t)width * 3, (uint32_t)width, (uint32_t)height, 8, PNG_COLOR_TYPE_RGB, NULL};
    if (result == TY_OK) result = write_png(context, &image8, path);
    ty_free_array(context, rgb8, pixels, 3);
    return result;
}

static uint16_t to_word(float value, double scale) {
    const double scaled = (double)value * scale;
    if (!(scaled > 0)) return 0; /* true for NaN too */
    return scaled < 65535 ? (uint16_t)(scaled + 0.5) : 65535;
}

ty_result ty_image_write_png16(ty_context* context, const ty_image* image, int32_t channel, double scale,
                               const char* path) {
    if (image == NULL || path == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_write_png16: an argument is NULL");
    const float* plane = ty_image_plane_const(image, channel);
    if (plane == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the image to write has no channel %d", path, (int)channel);
    if (!isfinite(scale)) return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the scale is not finite", path);
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const size_t pixels = (size_t)width * (size_t)height;
    uint16_t* words = ty_alloc_array(context, pixels, sizeof *words, false);
    if (words == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < pixels; ++i) words[i] = to_word(plane[i], scale);
    const raster gray16 = {words, (size_t)width * 2, (uint32_t)width, (uint32_t)height, 16, PNG_COLOR_TYPE_GRAY, NULL};
    const ty_result result = write_png(context, &gray16, path);
    ty_free_array(context, words, pixels, sizeof *words);
    return result;
}

ty_result ty_write_png_rgba8(ty_context* context, const uint8_t* rgba8, int32_t width, int32_t height, char* range,
                             const char* path) {
    const raster image8 = {rgba8, (size_t)width * 4, (uint32_t)width, (uint32_t)height, 8, PNG_COLOR_TYPE_RGBA, range};
    return write_png(context, &image8, path);
}
