/* Reading images of any supported format. */
#include "io/images/image_file.h"

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

ty_image_format ty_image_format_of(const uint8_t* bytes, size_t size) {
    static const struct {
        ty_image_format format;
        size_t size;
        uint8_t bytes[8];
    } magics[] = {{TY_IMAGE_EXR, 4, {0x76, 0x2f, 0x31, 0x01}},
                  {TY_IMAGE_HDR, 2, {'#', '?'}},
                  {TY_IMAGE_PNG, 8, {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}},
                  {TY_IMAGE_JPEG, 3, {0xff, 0xd8, 0xff}}};
    for (size_t i = 0; i < sizeof magics / sizeof *magics; ++i)
        if (size >= magics[i].size && memcmp(bytes, magics[i].bytes, magics[i].size) == 0) return magics[i].format;
    if (size >= 12 && memcmp(bytes, "RIFF", 4) == 0 && memcmp(bytes + 8, "WEBP", 4) == 0) return TY_IMAGE_WEBP;
    return TY_IMAGE_UNKNOWN;
}

static ty_result fail_unknown(ty_context* context, const char* path, size_t size) {
    if (size == 0) return ty_fail(context, TY_ERROR_INPUT, "%s: the file is empty", path);
    return ty_fail(context, TY_ERROR_INPUT, "%s: neither an OpenEXR, a Radiance .hdr, a PNG, a JPEG nor a WebP image",
                   path);
}

/* A side of a PNG, or the largest one that can be read. */
static uint64_t read_side(const uint8_t* at) {
    const uint32_t side = (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
    return side < TY_IMAGE_SIDE_MAX ? side : TY_IMAGE_SIDE_MAX;
}

/* A PNG's pixels take 8 bytes at most, and compression may add a little; a JPEG does not tell its size at once. Either
 * may have long texts and other pictures. */
ty_result ty_inspect_image(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form) {
    enum { PNG_WIDTH = 16, PNG_HEIGHT = 20, RIFF_SIZE = 4, RIFF_HEAD = 8, HEAD = 32 };
    const uint64_t extras = (uint64_t)1 << 30;
    if (size < HEAD) return TY_OK;
    switch (ty_image_format_of(head, size)) {
    case TY_IMAGE_EXR: form->longest = ty_exr_longest(head, size); break;
    case TY_IMAGE_HDR: form->longest = ty_hdr_longest(head, size); break;
    case TY_IMAGE_PNG: form->longest = 9 * read_side(head + PNG_WIDTH) * read_side(head + PNG_HEIGHT); break;
    case TY_IMAGE_JPEG: form->longest = 0; break;
    case TY_IMAGE_WEBP:
        form->longest = (uint64_t)head[RIFF_SIZE] | (uint64_t)head[RIFF_SIZE + 1] << 8 |
                        (uint64_t)head[RIFF_SIZE + 2] << 16 | (uint64_t)head[RIFF_SIZE + 3] << 24;
        form->longest += RIFF_HEAD;
        break;
    case TY_IMAGE_UNKNOWN: return fail_unknown(context, path, size);
    }
    const bool grows = form->longest <= UINT64_MAX - extras;
    form->longest = grows ? form->longest + extras : UINT64_MAX;
    return TY_OK;
}

static ty_result read_samples(ty_context* context, const char* path, const uint8_t* bytes, size_t size,
                              ty_result (*read)(ty_context*, const char*, const uint8_t*, size_t, ty_samples*),
                              ty_sample_use use, int32_t* largest, ty_image** out) {
    ty_samples samples;
    ty_result result = read(context, path, bytes, size, &samples);
    if (result != TY_OK) return result;
    if (largest != NULL) *largest = samples.wide ? 65535 : 255;
    result = ty_image_from_samples(context, &samples, use, out);
    ty_free_samples(context, &samples);
    return result;
}

ty_result ty_read_image_bytes(ty_context* context, const char* path, const uint8_t* bytes, size_t size,
                              ty_sample_use use, int32_t* largest, ty_image** out) {
    if (largest != NULL) *largest = 0;
    switch (ty_image_format_of(bytes, size)) {
    case TY_IMAGE_EXR: return ty_read_exr(context, path, bytes, size, out);
    case TY_IMAGE_HDR: return ty_read_hdr(context, path, bytes, size, out);
    case TY_IMAGE_PNG: return read_samples(context, path, bytes, size, ty_read_png, use, largest, out);
    case TY_IMAGE_JPEG: return read_samples(context, path, bytes, size, ty_read_jpeg, use, largest, out);
    case TY_IMAGE_WEBP: return read_samples(context, path, bytes, size, ty_read_webp, use, largest, out);
    case TY_IMAGE_UNKNOWN: break;
    }
    return fail_unknown(context, path, size);
}

static ty_result read_file(ty_context* context, const char* path, ty_sample_use use, int32_t* largest, ty_image** out) {
    if (out == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_read: out is NULL");
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_read_inspected_file(context, path, file_size_max, ty_inspect_image, &bytes, &size);
    if (result != TY_OK) return result;
    result = ty_read_image_bytes(context, path, bytes, size, use, largest, out);
    ty_free_file(context, bytes, size);
    return result;
}

ty_result ty_image_read(ty_context* context, const char* path, ty_image** out) {
    return read_file(context, path, TY_SAMPLES_LINEAR, NULL, out);
}

ty_result ty_image_read_raw(ty_context* context, const char* path, ty_image** out) {
    return read_file(context, path, TY_SAMPLES_RAW, NULL, out);
}

ty_result ty_image_read_whole(ty_context* context, const char* path, ty_image** out, int32_t* largest) {
    return read_file(context, path, TY_SAMPLES_WHOLE, largest, out);
}
