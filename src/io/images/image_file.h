/* Readers of image files in memory; `path` names the file in messages. */
#ifndef TY_IO_IMAGE_FILE_H
#define TY_IO_IMAGE_FILE_H

#include "image/image.h"
#include "io/file.h"

typedef enum ty_image_format {
    TY_IMAGE_UNKNOWN,
    TY_IMAGE_EXR,
    TY_IMAGE_HDR,
    TY_IMAGE_PNG,
    TY_IMAGE_JPEG,
    TY_IMAGE_WEBP
} ty_image_format;

/* Detects the format from the first bytes. */
ty_image_format ty_image_format_of(const uint8_t* bytes, size_t size);

ty_result ty_read_exr(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_image** out);
ty_result ty_read_hdr(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_image** out);

/* Samples of a PNG, JPEG or WebP file: rows from the top, interleaved gray (1 channel), gray and alpha (2), RGB (3) or
 * RGBA (4). */
typedef struct ty_samples {
    int32_t width, height, channels;
    bool wide;   /* 16-bit samples in native byte order, else 8-bit */
    void* data;  /* from ty_alloc_array */
    size_t size; /* bytes at data */
} ty_samples;

/* Allocates width * height * channels samples, uninitialised. */
ty_result ty_create_samples(ty_context* context, int32_t width, int32_t height, int32_t channels, bool wide,
                            ty_samples* out);
void ty_free_samples(ty_context* context, ty_samples* samples);

ty_result ty_read_png(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_samples* out);
ty_result ty_read_jpeg(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_samples* out);
ty_result ty_read_webp(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_samples* out);

/* Conversion of samples to floats. */
typedef enum ty_sample_use {
    TY_SAMPLES_LINEAR = 0, /* color from sRGB to linear; alpha to 0..1 */
    TY_SAMPLES_RAW = 1,    /* 0..1 */
    TY_SAMPLES_WHOLE = 2   /* 0..255 or 0..65535 */
} ty_sample_use;

/* Channels R, G, B or Y, and A if present. */
ty_result ty_image_from_samples(ty_context* context, const ty_samples* samples, ty_sample_use use, ty_image** out);

/* Decodes a PNG, JPEG or WebP to 8-bit RGBA in the file's sRGB encoding (16-bit samples are rounded, missing alpha is
 * 255); freed with ty_free_array(context, rgba8, width * height, 4). Thread-safe. */
ty_result ty_decode_rgba8(ty_context* context, const char* path, const uint8_t* bytes, size_t size, int32_t* width,
                          int32_t* height, uint8_t** rgba8);

/* Writes texels of four bytes as they are; range: of RGBM, a text of the file, or NULL. */
ty_result ty_write_png_rgba8(ty_context* context, const uint8_t* rgba8, int32_t width, int32_t height, char* range,
                             const char* path);

/* Bytes that an OpenEXR or Radiance file with this beginning may have; UINT64_MAX: unknown. */
uint64_t ty_exr_longest(const uint8_t* head, size_t size);
uint64_t ty_hdr_longest(const uint8_t* head, size_t size);

/* As ty_file_form_fn, for images of any format. */
ty_result ty_inspect_image(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form);

/* Reads an image of any format. largest: maximum of a PNG's, JPEG's or WebP's samples, 0 for other formats; may be
 * NULL. */
ty_result ty_read_image_bytes(ty_context* context, const char* path, const uint8_t* bytes, size_t size,
                              ty_sample_use use, int32_t* largest, ty_image** out);

/* Refuses sides and channel counts outside an image's limits, and images over 1 GiB whose file is too small for them
 * even at a compression of 1000:1. */
ty_result ty_check_image_size(ty_context* context, const char* path, size_t file_size, int64_t width, int64_t height,
                              int64_t channels);

#endif
