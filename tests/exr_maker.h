/* OpenEXR files as other writers might make them: half and uint channels, tiles, windows of any kind. */
#ifndef TY_TESTS_EXR_MAKER_H
#define TY_TESTS_EXR_MAKER_H

#include "files.h"

#include <OpenEXR/openexr.h>
#include <math.h>

/* Another writer's files: one uint, one half and one float channel in windows of their own. */
typedef struct foreign {
    exr_attr_box2i_t data, display;
    exr_compression_t compression;
    bool tiled;
} foreign;

enum { FOREIGN_CHANNELS = 3, TILE = 16 };
static const char* const foreign_names[FOREIGN_CHANNELS] = {"A", "B", "C"};
static const exr_pixel_type_t foreign_types[FOREIGN_CHANNELS] = {EXR_PIXEL_UINT, EXR_PIXEL_HALF, EXR_PIXEL_FLOAT};

/* The value at a pixel of the file's coordinates, exact in each of the types. */
static inline float foreign_value(int c, int32_t x, int32_t y) {
    const int32_t n = (x * 7 + y * 13 + c) & 1023;
    return c == 0 ? (float)n : (float)n / 64 - (float)c;
}

static inline void fill_foreign(int c, int32_t x0, int32_t y0, int32_t width, int32_t height, void* to) {
    for (int32_t i = 0; i < width * height; ++i) {
        const float value = foreign_value(c, x0 + i % width, y0 + i / width);
        if (c == 0) ((uint32_t*)to)[i] = (uint32_t)value;
        if (c == 2) ((float*)to)[i] = value;
        if (c != 1) continue;
        /* value is k / 64 with |k| < 2048: a normal half, or 0 */
        int exponent = 0;
        const float mantissa = frexpf(fabsf(value), &exponent);
        const uint16_t bits = (uint16_t)((exponent + 14) << 10 | ((int)ldexpf(mantissa, 11) & 1023));
        ((uint16_t*)to)[i] = value == 0 ? 0 : (uint16_t)(bits | (value < 0 ? 0x8000 : 0));
    }
}

static inline void ignore_message(exr_const_context_t exr, exr_result_t code, const char* text) {
    (void)exr;
    (void)code;
    (void)text;
}

static inline void encode_chunk(exr_context_t exr, const exr_chunk_info_t* info, int32_t x0, int32_t y0) {
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_encoding_initialize(exr, 0, info, &encode), 0);
    void* values[FOREIGN_CHANNELS];
    for (int c = 0; c < encode.channel_count; ++c) {
        values[c] = malloc((size_t)info->width * (size_t)info->height * 4);
        assert_non_null(values[c]);
        fill_foreign(c, x0, y0, info->width, info->height, values[c]);
        const int size = foreign_types[c] == EXR_PIXEL_HALF ? 2 : 4;
        encode.channels[c].encode_from_ptr = values[c];
        encode.channels[c].user_pixel_stride = size;
        encode.channels[c].user_line_stride = size * info->width;
    }
    assert_int_equal(exr_encoding_choose_default_routines(exr, 0, &encode), 0);
    assert_int_equal(exr_encoding_run(exr, 0, &encode), 0);
    for (int c = 0; c < encode.channel_count; ++c) free(values[c]);
    exr_encoding_destroy(exr, &encode);
}

static inline void write_foreign(const char* path, const foreign* f) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = ignore_message;
    exr_context_t exr = NULL;
    const exr_attr_v2f_t centre = {.x = 0, .y = 0};
    int part = 0;
    assert_int_equal(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &setup), 0);
    assert_int_equal(exr_add_part(exr, "part", f->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part), 0);
    assert_int_equal(exr_initialize_required_attr(exr, 0, &f->display, &f->data, 1, &centre, 1,
                                                  EXR_LINEORDER_INCREASING_Y, f->compression),
                     0);
    if (f->tiled)
        assert_int_equal(exr_set_tile_descriptor(exr, 0, TILE, TILE, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN), 0);
    for (int c = 0; c < FOREIGN_CHANNELS; ++c)
        assert_int_equal(
            exr_add_channel(exr, 0, foreign_names[c], foreign_types[c], EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1), 0);
    assert_int_equal(exr_write_header(exr), 0);
    const int32_t width = f->data.max.x - f->data.min.x + 1;
    exr_chunk_info_t info;
    int32_t lines = 0;
    if (f->tiled) {
        for (int32_t y = 0; f->data.min.y + y * TILE <= f->data.max.y; ++y)
            for (int32_t x = 0; x * TILE < width; ++x) {
                assert_int_equal(exr_write_tile_chunk_info(exr, 0, x, y, 0, 0, &info), 0);
                encode_chunk(exr, &info, f->data.min.x + x * TILE, f->data.min.y + y * TILE);
            }
    } else {
        assert_int_equal(exr_get_scanlines_per_chunk(exr, 0, &lines), 0);
        for (int32_t y = f->data.min.y; y <= f->data.max.y; y += lines) {
            assert_int_equal(exr_write_scanline_chunk_info(exr, 0, y, &info), 0);
            encode_chunk(exr, &info, f->data.min.x, y);
        }
    }
    assert_int_equal(exr_finish(&exr), 0);
}

static inline exr_attr_box2i_t box(int32_t x0, int32_t y0, int32_t x1, int32_t y1) {
    exr_attr_box2i_t made;
    made.min.x = x0;
    made.min.y = y0;
    made.max.x = x1;
    made.max.y = y1;
    return made;
}

#endif
