/* Readers of image files that are in memory; path stands for the file in messages. */
#ifndef TY_IO_IMAGE_FILE_H
#define TY_IO_IMAGE_FILE_H

#include "image/image.h"

ty_result ty_read_exr(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_image** out);
ty_result ty_read_hdr(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_image** out);

/* Told by content. */
ty_result ty_read_image_bytes(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_image** out);

/* Refuses sides and channel counts outside an image's limits, and images over 1 GiB whose file is too small to hold
 * them even if it compresses a thousandfold. */
ty_result ty_check_image_size(ty_context* context, const char* path, size_t file_size, int64_t width, int64_t height,
                              int64_t channels);

#endif
