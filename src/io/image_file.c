/* Reading images of any known kind. */
#include "io/image_file.h"

#include "base/context.h"
#include "io/file.h"

#include <string.h>
#include <tyndall/io.h>

static const size_t file_size_max = (size_t)1 << 36;

ty_result ty_check_image_size(ty_context* context, const char* path, size_t file_size, int64_t width, int64_t height,
                              int64_t channels) {
    if (width < 1 || height < 1 || width > TY_IMAGE_SIDE_MAX || height > TY_IMAGE_SIDE_MAX)
        return ty_fail(context, TY_ERROR_INPUT, "%s: the image is %lld x %lld pixels, outside 1..%d", path,
                       (long long)width, (long long)height, (int)TY_IMAGE_SIDE_MAX);
    if (channels < 1 || channels > TY_IMAGE_CHANNELS_MAX)
        return ty_fail(context, TY_ERROR_INPUT, "%s: the image has %lld channels, outside 1..%d", path,
                       (long long)channels, (int)TY_IMAGE_CHANNELS_MAX);
    const double bytes = (double)width * (double)height * (double)channels * sizeof(float);
    if (bytes > 0x1p30 + 1024.0 * (double)file_size)
        return ty_fail(context, TY_ERROR_INPUT, "%s: %zu bytes cannot hold %lld x %lld pixels of %lld channels", path,
                       file_size, (long long)width, (long long)height, (long long)channels);
    return TY_OK;
}

ty_result ty_read_image_bytes(ty_context* context, const char* path, const uint8_t* bytes, size_t size,
                              ty_image** out) {
    static const uint8_t exr_magic[] = {0x76, 0x2f, 0x31, 0x01}, hdr_magic[] = {'#', '?'};
    if (size >= sizeof exr_magic && memcmp(bytes, exr_magic, sizeof exr_magic) == 0)
        return ty_read_exr(context, path, bytes, size, out);
    if (size >= sizeof hdr_magic && memcmp(bytes, hdr_magic, sizeof hdr_magic) == 0)
        return ty_read_hdr(context, path, bytes, size, out);
    return ty_fail(context, TY_ERROR_INPUT, "%s: neither an OpenEXR nor a Radiance .hdr image", path);
}

ty_result ty_image_read(ty_context* context, const char* path, ty_image** out) {
    if (out == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_read: out is NULL");
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_read_file(context, path, file_size_max, &bytes, &size);
    if (result != TY_OK) return result;
    result = ty_read_image_bytes(context, path, bytes, size, out);
    ty_free_file(context, bytes, size);
    return result;
}
