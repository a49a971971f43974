/* Pixels of an image within report.html. */
#include "cli/compare/page_pixels.h"
#include "base/half.h"

#include <math.h>
#include <stdlib.h>
#include <zlib.h>

/* The target of the largest value in half precision, below the maximum of 65504. */
static const int largest_exponent = 15;

typedef struct pixels {
    const float* planes[3];
    int32_t width, height, shrink;
    int32_t columns, rows; /* exponent of the scale */
    int exponent;
} pixels;

/* Half floats have few stops for small values, so the image is scaled to put its maximum near their upper end. */
static int find_exponent(const pixels* p) {
    float largest = 0;
    for (int c = 0; c < 3; ++c)
        for (int64_t i = 0; i < (int64_t)p->width * p->height; ++i)
            if (isfinite(p->planes[c][i])) largest = fmaxf(largest, fabsf(p->planes[c][i]));
    int exponent = largest_exponent;
    if (largest > 0) frexpf(largest, &exponent);
    return exponent - largest_exponent;
}

/* The mean over a block of pixels, clipped at the image border. */
static double mean_at(const pixels* p, const float* plane, int32_t column, int32_t row) {
    const int32_t x0 = column * p->shrink, y0 = row * p->shrink;
    double sum = 0;
    int count = 0;
    for (int32_t y = y0; y < y0 + p->shrink && y < p->height; ++y)
        for (int32_t x = x0; x < x0 + p->shrink && x < p->width; ++x, ++count)
            sum += (double)plane[(int64_t)y * p->width + x];
    return sum / count;
}

static void pack_planes(const pixels* p, uint8_t* out) {
    const size_t count = 3 * (size_t)p->columns * (size_t)p->rows;
    const double scale = ldexp(1, -p->exponent);
    size_t at = 0;
    for (int c = 0; c < 3; ++c)
        for (int32_t row = 0; row < p->rows; ++row) {
            uint16_t left = 0;
            for (int32_t column = 0; column < p->columns; ++column, ++at) {
                const uint16_t half = ty_float_to_half((float)(scale * mean_at(p, p->planes[c], column, row)));
                const uint16_t difference = (uint16_t)(half - left);
                const uint16_t folded = (uint16_t)(difference << 1 ^ (difference >> 15 != 0 ? 0xffff : 0));
                out[at] = (uint8_t)folded;
                out[count + at] = (uint8_t)(folded >> 8);
                left = half;
            }
        }
}

static void write_base64(FILE* file, const uint8_t* bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const uint32_t bits =
            (uint32_t)bytes[i] << 16 | (left > 1 ? (uint32_t)bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0);
        const char group[4] = {digits[bits >> 18], digits[bits >> 12 & 63], left > 1 ? digits[bits >> 6 & 63] : '=',
                               left > 2 ? digits[bits & 63] : '='};
        fwrite(group, 1, sizeof group, file);
    }
}

static ty_result write_packed(FILE* file, const pixels* p) {
    const size_t size = 6 * (size_t)p->columns * (size_t)p->rows;
    uLongf packed_size = compressBound((uLong)size);
    uint8_t* planes = malloc(size);
    uint8_t* packed = malloc(packed_size);
    ty_result result = TY_ERROR_MEMORY;
    if (planes != NULL && packed != NULL) {
        pack_planes(p, planes);
        if (compress2(packed, &packed_size, planes, (uLong)size, Z_DEFAULT_COMPRESSION) == Z_OK) result = TY_OK;
    }
    if (result == TY_OK) write_base64(file, packed, packed_size);
    free(packed);
    free(planes);
    return result;
}

ty_result cli_write_page_pixels(ty_context* context, FILE* file, const ty_image* image, int32_t shrink) {
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    ty_image* filled = NULL;
    ty_result result = ty_image_create_full_frame(context, image, &filled);
    if (result != TY_OK) return result;
    pixels p = {.width = frame[2], .height = frame[3], .shrink = shrink};
    p.columns = (frame[2] + shrink - 1) / shrink;
    p.rows = (frame[3] + shrink - 1) / shrink;
    if (!ty_image_rgb_planes(filled, p.planes)) result = TY_ERROR_ARGUMENT;
    if (result == TY_OK) {
        p.exponent = find_exponent(&p);
        fprintf(file,
                "<script type=\"application/octet-stream\" class=\"pixels\" data-exponent=\"%d\" "
                "data-window=\"%d %d %d %d\">",
                p.exponent, frame[0], frame[1], ty_image_width(image), ty_image_height(image));
        result = write_packed(file, &p);
        fputs("</script>\n", file);
    }
    ty_image_destroy(filled);
    return result;
}
