/* Floats as texels of each format. */
#include "base/context.h"
#include "base/half.h"
#include "io/textures/bc6h.h"
#include "io/textures/textures.h"

#include <math.h>
#include <string.h>

/* The largest half float. */
#define HALF_MAX 65504.0f

static size_t texel_size(ty_texel_format format) {
    return format == TY_TEXELS_HALF ? 8 : format == TY_TEXELS_FLOAT ? 16 : 4;
}

static bool in_blocks(ty_texel_format format) {
    return format == TY_TEXELS_BC6H || format == TY_TEXELS_BC6H_SIGNED;
}

size_t ty_texel_bytes(ty_texel_format format, const int32_t size[3]) {
    const size_t width = (size_t)size[0], height = (size_t)size[1], depth = (size_t)size[2];
    if (in_blocks(format)) return (width + 3) / 4 * ((height + 3) / 4) * depth * TY_BC6H_BLOCK_BYTES;
    return width * height * depth * texel_size(format);
}

static uint8_t to_byte(float value) {
    return (uint8_t)fminf(fmaxf(value + 0.5f, 0), 255);
}

/* Floats of 9 bits with a common exponent of bias 15 (EXT_texture_shared_exponent, "3.8.x"). */
static uint32_t pack_rgb9e5(const float rgb[3]) {
    float bounded[3], largest = 0;
    for (int c = 0; c < 3; ++c) {
        bounded[c] = fminf(fmaxf(rgb[c], 0), 65408.0f);
        largest = fmaxf(largest, bounded[c]);
    }
    int exponent = -16;
    if (largest > 0) {
        frexpf(largest, &exponent); /* largest = m 2^exponent, m in [0.5, 1) */
        --exponent;
    }
    int shared = (exponent > -16 ? exponent : -16) + 16;
    float step = ldexpf(1, shared - 24);
    if (floorf(largest / step + 0.5f) >= 512) {
        ++shared;
        step *= 2;
    }
    uint32_t packed = (uint32_t)shared << 27;
    for (int c = 0; c < 3; ++c) packed |= (uint32_t)floorf(bounded[c] / step + 0.5f) << (9 * c);
    return packed;
}

/* A byte per channel and an exponent of bias 128 + 8 (Ward 1991), without his half a step. */
static void pack_rgbe(const float rgb[3], uint8_t out[4]) {
    const float largest = fmaxf(fmaxf(rgb[0], rgb[1]), rgb[2]);
    memset(out, 0, 4);
    if (!(largest > 1e-32f)) return;
    int exponent;
    frexpf(largest, &exponent);
    if (floorf(ldexpf(largest, 8 - exponent) + 0.5f) >= 256) ++exponent;
    for (int c = 0; c < 3; ++c) out[c] = to_byte(ldexpf(rgb[c], 8 - exponent));
    out[3] = (uint8_t)(exponent + 128);
}

/* A byte per channel and a multiplier, the smallest that holds the largest channel. */
static void pack_rgbm(const float rgb[3], float range, uint8_t out[4]) {
    const float largest = fmaxf(fmaxf(rgb[0], rgb[1]), rgb[2]) / range;
    const float multiplier = fminf(fmaxf(ceilf(255 * largest), 1), 255);
    for (int c = 0; c < 3; ++c) out[c] = to_byte(rgb[c] / range * (255 * 255 / multiplier));
    out[3] = (uint8_t)multiplier;
}

static void pack(ty_texel_format format, float range, const float rgba[4], uint8_t* out) {
    switch (format) {
    case TY_TEXELS_HALF:
        for (int c = 0; c < 4; ++c) {
            const uint16_t half = ty_float_to_half(fminf(fmaxf(rgba[c], -HALF_MAX), HALF_MAX));
            out[2 * c] = (uint8_t)half;
            out[2 * c + 1] = (uint8_t)(half >> 8);
        }
        break;
    case TY_TEXELS_FLOAT:
        for (int c = 0; c < 4; ++c) ty_put_le32(out + 4 * c, ty_bits_from_float(rgba[c]));
        break;
    case TY_TEXELS_RGB9E5: ty_put_le32(out, pack_rgb9e5(rgba)); break;
    case TY_TEXELS_RGBE: pack_rgbe(rgba, out); break;
    default: pack_rgbm(rgba, range, out);
    }
}

/* ---- Blocks ---- */

typedef struct block_rows {
    ty_bc6h_request request; /* of the first slice */
    int32_t rows;            /* rows of blocks in a slice */
} block_rows;

static void encode_row(void* user, int64_t index, int32_t worker) {
    const block_rows* all = user;
    ty_bc6h_request slice = all->request;
    const size_t number = (size_t)(index / all->rows), texels = (size_t)slice.width * (size_t)slice.height;
    (void)worker;
    slice.halves += 3 * texels * number;
    slice.blocks += (size_t)TY_BC6H_BLOCK_BYTES * (size_t)((slice.width + 3) / 4) * (size_t)all->rows * number;
    ty_bc6h_encode_row(&slice, (int32_t)(index % all->rows));
}

static ty_result encode_blocks(ty_context* context, bool with_sign, const float* rgba, const int32_t size[3],
                               uint8_t* out) {
    const size_t texels = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    uint16_t* halves = ty_alloc_array(context, texels, 3 * sizeof *halves, false);
    ty_bc6h_tables* tables = ty_alloc_array(context, 1, sizeof *tables, false);
    if (halves != NULL && tables != NULL) {
        for (size_t i = 0; i < texels; ++i)
            for (size_t c = 0; c < 3; ++c)
                halves[3 * i + c] = ty_float_to_half(fminf(fmaxf(rgba[4 * i + c], -HALF_MAX), HALF_MAX));
        ty_bc6h_fill_tables(tables);
        block_rows rows = {.rows = (size[1] + 3) / 4,
                           .request = {.tables = tables,
                                       .halves = halves,
                                       .blocks = out,
                                       .width = size[0],
                                       .height = size[1],
                                       .with_sign = with_sign,
                                       .modes = ~0u}};
        ty_parallel_for(context, (int64_t)rows.rows * size[2], encode_row, &rows);
    }
    const ty_result result = halves == NULL || tables == NULL ? TY_ERROR_MEMORY : TY_OK;
    ty_free_array(context, tables, 1, sizeof *tables);
    ty_free_array(context, halves, texels, 3 * sizeof *halves);
    return result;
}

ty_result ty_encode_texels(ty_context* context, ty_texel_format format, double range, const float* rgba,
                           const int32_t size[3], uint8_t* out) {
    if (in_blocks(format)) return encode_blocks(context, format == TY_TEXELS_BC6H_SIGNED, rgba, size, out);
    const size_t texels = (size_t)size[0] * (size_t)size[1] * (size_t)size[2], each = texel_size(format);
    for (size_t i = 0; i < texels; ++i) pack(format, (float)range, rgba + 4 * i, out + each * i);
    return TY_OK;
}
