/* Radiance .hdr images (RGBE; flat, old or new run-length encoding), top row first. EXPOSURE lines are ignored, as
 * is customary for environment maps. */
#include "io/images/image_file.h"

#include "base/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    const uint8_t* at;
    const uint8_t* end;
} reader;

static size_t bytes_left(const reader* r) {
    return (size_t)(r->end - r->at);
}

enum { LINE_SIZE = 256 };

/* Reads the next header line without its end, truncated to LINE_SIZE; false at the end of the file. */
static bool next_line(reader* r, char line[LINE_SIZE]) {
    const uint8_t* newline = bytes_left(r) > 0 ? memchr(r->at, '\n', bytes_left(r)) : NULL;
    if (newline == NULL) return false;
    size_t length = (size_t)(newline - r->at);
    if (length > LINE_SIZE - 1) length = LINE_SIZE - 1;
    memcpy(line, r->at, length);
    if (length > 0 && line[length - 1] == '\r') --length;
    line[length] = '\0';
    r->at = newline + 1;
    return true;
}

/* Parses "-Y 512 +X 1024", the only orientation in use. */
static bool parse_size(const char* line, int64_t* width, int64_t* height) {
    if (strncmp(line, "-Y ", 3) != 0) return false;
    char* rest;
    *height = strtoll(line + 3, &rest, 10);
    if (strncmp(rest, " +X ", 4) != 0) return false;
    *width = strtoll(rest + 4, &rest, 10);
    return *rest == '\0';
}

static ty_result read_header(ty_context* context, const char* path, reader* r, int64_t* width, int64_t* height) {
    char line[LINE_SIZE];
    bool rgbe = false;
    while (next_line(r, line) && line[0] != '\0') {
        if (strncmp(line, "FORMAT=", 7) != 0) continue;
        rgbe = strcmp(line + 7, "32-bit_rle_rgbe") == 0;
        if (!rgbe) return ty_fail(context, TY_ERROR_INPUT, "%s: pixels are %s, not 32-bit_rle_rgbe", path, line + 7);
    }
    if (!rgbe || !next_line(r, line))
        return ty_fail(context, TY_ERROR_INPUT, "%s: the header is damaged or cut short", path);
    if (!parse_size(line, width, height))
        return ty_fail(context, TY_ERROR_INPUT, "%s: the image size is given as \"%s\", not as -Y HEIGHT +X WIDTH",
                       path, line);
    return TY_OK;
}

/* Reads one of the four planes of a scanline: runs (128 + n, value) and literals (n, values ...). */
static bool read_plane(reader* r, uint8_t* rgbe, size_t width) {
    for (size_t x = 0; x < width;) {
        if (bytes_left(r) < 2) return false;
        size_t count = *r->at++;
        const bool run = count > 128;
        if (run) count -= 128;
        if (count == 0 || count > width - x || (!run && bytes_left(r) < count)) return false;
        for (size_t i = 0; i < count; ++i, ++x) rgbe[4 * x] = r->at[run ? 0 : i];
        r->at += run ? 1 : count;
    }
    return true;
}

/* Reads flat pixels and old run-length encoding: (1, 1, 1, n) repeats the last pixel n times, n << 8 times after
 * another such code, and so on. */
static bool read_pixels(reader* r, uint8_t* rgbe, size_t width) {
    unsigned shift = 0;
    for (size_t x = 0; x < width;) {
        if (bytes_left(r) < 4) return false;
        const uint8_t* pixel = r->at;
        r->at += 4;
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            memcpy(rgbe + 4 * x++, pixel, 4);
            shift = 0;
            continue;
        }
        if (x == 0 || shift > 16) return false;
        const size_t count = (size_t)pixel[3] << shift;
        if (count > width - x) return false;
        for (size_t i = 0; i < count; ++i, ++x) memcpy(rgbe + 4 * x, rgbe + 4 * (x - 1), 4);
        shift += 8;
    }
    return true;
}

static bool read_scanline(reader* r, uint8_t* rgbe, size_t width) {
    /* Flat data cannot start this way: a normalised pixel has one of R, G and B at least 128. */
    const bool planes =
        width >= 8 && width < 32768 && bytes_left(r) >= 4 && r->at[0] == 2 && r->at[1] == 2 && r->at[2] < 128;
    if (!planes) return read_pixels(r, rgbe, width);
    if ((size_t)(r->at[2] << 8 | r->at[3]) != width) return false;
    r->at += 4;
    for (int c = 0; c < 4; ++c)
        if (!read_plane(r, rgbe + c, width)) return false;
    return true;
}

static bool read_rows(reader* r, ty_image* image, uint8_t* rgbe) {
    float* planes[3];
    for (int c = 0; c < 3; ++c) planes[c] = ty_image_plane(image, c);
    const size_t width = (size_t)image->width;
    for (size_t y = 0; y < (size_t)image->height; ++y) {
        if (!read_scanline(r, rgbe, width)) return false;
        for (size_t x = 0; x < width; ++x) {
            const uint8_t* pixel = rgbe + 4 * x;
            const float unit = pixel[3] == 0 ? 0 : ldexpf(1, pixel[3] - (128 + 8));
            for (int c = 0; c < 3; ++c) planes[c][y * width + x] = (float)pixel[c] * unit;
        }
    }
    return true;
}

ty_result ty_read_hdr(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_image** out) {
    reader r = {bytes, bytes + size};
    int64_t width = 0, height = 0;
    ty_result result = read_header(context, path, &r, &width, &height);
    if (result == TY_OK) result = ty_check_image_size(context, path, size, width, height, 3);
    if (result != TY_OK) return result;
    if (bytes_left(&r) < (size_t)height * 4)
        return ty_fail(context, TY_ERROR_INPUT, "%s: cut short: %zu bytes for %lld rows", path, bytes_left(&r),
                       (long long)height);
    ty_image* image = NULL;
    uint8_t* rgbe = ty_alloc_array(context, (size_t)width, 4, false);
    result = rgbe == NULL ? TY_ERROR_MEMORY : ty_image_create_rgb(context, (int32_t)width, (int32_t)height, &image);
    if (result == TY_OK && !read_rows(&r, image, rgbe))
        result = ty_fail(context, TY_ERROR_INPUT, "%s: the pixels are damaged or cut short", path);
    ty_free_array(context, rgbe, (size_t)width, 4);
    if (result != TY_OK) {
        ty_image_destroy(image);
        return result;
    }
    *out = image;
    return TY_OK;
}

/* A pixel takes four bytes, or four planes' literals with a length before each 128 of them. */
uint64_t ty_hdr_longest(const uint8_t* head, size_t size) {
    enum { PIXEL_MAX = 8 };
    reader r = {head, head + size};
    char line[LINE_SIZE];
    int64_t width = 0, height = 0;
    while (next_line(&r, line) && line[0] != '\0') continue;
    if (!next_line(&r, line) || !parse_size(line, &width, &height)) return UINT64_MAX;
    if (width < 1 || height < 1 || width > TY_IMAGE_SIDE_MAX || height > TY_IMAGE_SIDE_MAX) return UINT64_MAX;
    return (uint64_t)(r.at - head) + PIXEL_MAX * (uint64_t)width * (uint64_t)height;
}
