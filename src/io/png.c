/* Writing 8-bit sRGB PNG. */
#include "base/context.h"
#include "io/file.h"

#include <png.h>
#include <setjmp.h>
#include <string.h>
#include <tyndall/io.h>

enum { MESSAGE_SIZE = 128 };

static void keep_message(png_structp png, png_const_charp text) {
    char* message = png_get_error_ptr(png);
    strncpy(message, text, MESSAGE_SIZE - 1);
    longjmp(png_jmpbuf(png), 1);
}

static void ignore_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

/* libpng leaves by longjmp; nothing here is changed between setjmp and that. */
static bool encode(png_structp png, png_infop info, FILE* stream, const uint8_t* rgb8, uint32_t width,
                   uint32_t height) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_init_io(png, stream);
    png_set_IHDR(png, info, width, height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    for (uint32_t y = 0; y < height; ++y) png_write_row(png, rgb8 + (size_t)y * width * 3);
    png_write_end(png, info);
    return true;
}

static ty_result write_png(ty_context* context, const uint8_t* rgb8, int32_t width, int32_t height, const char* path) {
    char message[MESSAGE_SIZE] = "";
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, message, keep_message, ignore_warning);
    png_infop info = png == NULL ? NULL : png_create_info_struct(png);
    ty_output output;
    ty_result result = info == NULL ? ty_fail(context, TY_ERROR_MEMORY, "not enough memory to write %s", path) : TY_OK;
    if (result == TY_OK) result = ty_output_open(context, path, &output);
    if (result == TY_OK) {
        if (encode(png, info, output.stream, rgb8, (uint32_t)width, (uint32_t)height)) {
            result = ty_output_commit(context, &output);
        } else {
            ty_output_discard(context, &output);
            result = ty_fail(context, TY_ERROR_FILE, "cannot write %s: %s", path, message);
        }
    }
    png_destroy_write_struct(&png, &info);
    return result;
}

ty_result ty_image_write_png(ty_context* context, const ty_image* image, double exposure, bool curve,
                             const char* path) {
    if (image == NULL || path == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_write_png: an argument is NULL");
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const size_t pixels = (size_t)width * (size_t)height;
    uint8_t* rgb8 = ty_alloc_array(context, pixels, 3, false);
    if (rgb8 == NULL) return TY_ERROR_MEMORY;
    ty_result result = ty_image_tonemap(context, image, exposure, curve, rgb8);
    if (result == TY_OK) result = write_png(context, rgb8, width, height, path);
    ty_free_array(context, rgb8, pixels, 3);
    return result;
}
