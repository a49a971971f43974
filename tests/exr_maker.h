/* OpenEXR files as other writers might make them: half and uint channels, tiles with and without levels, windows of any
 * kind, several parts. */
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
    exr_tile_level_mode_t levels; /* the core library writes no ripmaps */
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

static inline void encode_chunk(exr_context_t exr, int part, const exr_chunk_info_t* info, int32_t x0, int32_t y0) {
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_encoding_initialize(exr, part, info, &encode), 0);
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
    assert_int_equal(exr_encoding_choose_default_routines(exr, part, &encode), 0);
    assert_int_equal(exr_encoding_run(exr, part, &encode), 0);
    for (int c = 0; c < encode.channel_count; ++c) free(values[c]);
    exr_encoding_destroy(exr, &encode);
}

static inline void add_foreign_part(exr_context_t exr, const char* name, const foreign* f) {
    const exr_attr_v2f_t centre = {.x = 0, .y = 0};
    int part = 0;
    assert_int_equal(exr_add_part(exr, name, f->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part), 0);
    assert_int_equal(exr_initialize_required_attr(exr, part, &f->display, &f->data, 1, &centre, 1,
                                                  EXR_LINEORDER_INCREASING_Y, f->compression),
                     0);
    if (f->tiled) assert_int_equal(exr_set_tile_descriptor(exr, part, TILE, TILE, f->levels, EXR_TILE_ROUND_DOWN), 0);
    for (int c = 0; c < FOREIGN_CHANNELS; ++c)
        assert_int_equal(
            exr_add_channel(exr, part, foreign_names[c], foreign_types[c], EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1), 0);
}

/* One level, with the pixels of another place when it is not the largest. */
static inline void write_level(exr_context_t exr, int part, const foreign* f, int level) {
    int32_t width = 0, height = 0, tile_width = 0, tile_height = 0;
    assert_int_equal(exr_get_level_sizes(exr, part, level, level, &width, &height), 0);
    assert_int_equal(exr_get_tile_sizes(exr, part, level, level, &tile_width, &tile_height), 0);
    const int32_t shift = 1000 * level;
    exr_chunk_info_t info;
    for (int32_t y = 0; y * tile_height < height; ++y)
        for (int32_t x = 0; x * tile_width < width; ++x) {
            assert_int_equal(exr_write_tile_chunk_info(exr, part, x, y, level, level, &info), 0);
            encode_chunk(exr, part, &info, f->data.min.x + x * tile_width + shift, f->data.min.y + y * tile_height);
        }
}

static inline void write_levels(exr_context_t exr, int part, const foreign* f) {
    int32_t across = 0, down = 0;
    assert_int_equal(exr_get_tile_levels(exr, part, &across, &down), 0);
    for (int level = 0; level < across; ++level) write_level(exr, part, f, level);
}

static inline void write_scanlines(exr_context_t exr, int part, const foreign* f) {
    int32_t lines = 0;
    exr_chunk_info_t info;
    assert_int_equal(exr_get_scanlines_per_chunk(exr, part, &lines), 0);
    for (int32_t y = f->data.min.y; y <= f->data.max.y; y += lines) {
        assert_int_equal(exr_write_scanline_chunk_info(exr, part, y, &info), 0);
        encode_chunk(exr, part, &info, f->data.min.x, y);
    }
}

/* Parts are called "part", "part1", "part2" ... */
static inline void write_foreign_parts(const char* path, const foreign* parts, int count) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = ignore_message;
    exr_context_t exr = NULL;
    assert_int_equal(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &setup), 0);
    for (int i = 0; i < count; ++i) {
        char name[16] = "part";
        if (i > 0) snprintf(name, sizeof name, "part%d", i);
        add_foreign_part(exr, name, &parts[i]);
    }
    assert_int_equal(exr_write_header(exr), 0);
    for (int i = 0; i < count; ++i) {
        if (parts[i].tiled)
            write_levels(exr, i, &parts[i]);
        else
            write_scanlines(exr, i, &parts[i]);
    }
    assert_int_equal(exr_finish(&exr), 0);
}

static inline void write_foreign(const char* path, const foreign* f) {
    write_foreign_parts(path, f, 1);
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
