/* PNG and JPEG files as other writers might make them. */
#ifndef TY_TESTS_IMAGE_MAKER_H
#define TY_TESTS_IMAGE_MAKER_H

#include "files.h"

#include <png.h>

#include <jpeglib.h>

/* A PNG of one colour type and depth. transparent: palettes have alphas, and gray and RGB one transparent colour, that
 * of the first pixel. */
typedef struct png_kind {
    int colour, depth;
    bool interlaced, transparent;
} png_kind;

enum { MADE_WIDTH = 37, MADE_HEIGHT = 21, PALETTE_SIZE = 5, PALETTE_ALPHAS = 3 };

static inline int png_file_channels(int colour) {
    return colour == PNG_COLOR_TYPE_RGB_ALPHA    ? 4
           : colour == PNG_COLOR_TYPE_RGB        ? 3
           : colour == PNG_COLOR_TYPE_GRAY_ALPHA ? 2
                                                 : 1;
}

/* The sample in the file. */
static inline uint32_t png_value(const png_kind* kind, int x, int y, int channel) {
    const uint32_t mixed = (uint32_t)(x / 2 * 7919 + y * 104729 + channel * 15485863 + 12345) * 2654435761u >> 8;
    if (kind->colour == PNG_COLOR_TYPE_PALETTE) {
        const uint32_t entries = kind->depth == 1 ? 2 : kind->depth == 2 ? 4 : PALETTE_SIZE;
        return mixed % entries;
    }
    return mixed & ((1u << kind->depth) - 1);
}

static inline png_color palette_entry(uint32_t i) {
    return (png_color){(png_byte)(50 * i), (png_byte)(255 - i), (png_byte)(i * i + 3)};
}

static inline png_byte palette_alpha(uint32_t i) {
    return (png_byte)(i < PALETTE_ALPHAS ? 90 * i : 255);
}

static inline void set_png_colours(png_structp png, png_infop info, const png_kind* kind) {
    if (kind->colour == PNG_COLOR_TYPE_PALETTE) {
        png_color palette[PALETTE_SIZE];
        png_byte alphas[PALETTE_ALPHAS];
        for (uint32_t i = 0; i < PALETTE_SIZE; ++i) palette[i] = palette_entry(i);
        for (uint32_t i = 0; i < PALETTE_ALPHAS; ++i) alphas[i] = palette_alpha(i);
        const int size = kind->depth == 1 ? 2 : kind->depth == 2 ? 4 : PALETTE_SIZE;
        png_set_PLTE(png, info, palette, size);
        if (kind->transparent) png_set_tRNS(png, info, alphas, size < PALETTE_ALPHAS ? size : PALETTE_ALPHAS, NULL);
    } else if (kind->transparent) {
        png_color_16 colour = {0};
        colour.gray = colour.red = (png_uint_16)png_value(kind, 0, 0, 0);
        colour.green = (png_uint_16)png_value(kind, 0, 0, 1);
        colour.blue = (png_uint_16)png_value(kind, 0, 0, 2);
        png_set_tRNS(png, info, NULL, 0, &colour);
    }
}

static inline void write_kind(const char* path, const png_kind* kind) {
    remove(path);
    FILE* stream = fopen(path, "wb");
    assert_non_null(stream);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, stream);
    png_set_IHDR(png, info, MADE_WIDTH, MADE_HEIGHT, kind->depth, kind->colour,
                 kind->interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    set_png_colours(png, info, kind);
    png_write_info(png, info);
    png_set_packing(png);
    const int passes = png_set_interlace_handling(png);
    const int channels = png_file_channels(kind->colour);
    for (int pass = 0; pass < passes; ++pass)
        for (int y = 0; y < MADE_HEIGHT; ++y) {
            png_byte row[MADE_WIDTH * 8], *at = row;
            for (int i = 0; i < MADE_WIDTH * channels; ++i) {
                const uint32_t value = png_value(kind, i / channels, y, i % channels);
                if (kind->depth == 16) *at++ = (png_byte)(value >> 8);
                *at++ = (png_byte)value;
            }
            png_write_row(png, row);
        }
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(stream), 0);
}

typedef struct jpeg_kind {
    J_COLOR_SPACE from, to; /* of the values, in the file */
    bool progressive, without_adobe_marker;
    bool many_scans; /* of gray: three for each of the 63 coefficients beside the mean */
} jpeg_kind;

enum { MANY_SCANS = 1 + 3 * 63 };

static inline void plan_many_scans(jpeg_scan_info scans[MANY_SCANS]) {
    scans[0] = (jpeg_scan_info){.comps_in_scan = 1};
    for (int i = 1; i < MANY_SCANS; ++i) {
        const int coefficient = 1 + (i - 1) % 63, pass = (i - 1) / 63;
        scans[i] = (jpeg_scan_info){
            .comps_in_scan = 1, .Ss = coefficient, .Se = coefficient, .Ah = pass == 0 ? 0 : 3 - pass, .Al = 2 - pass};
    }
}

/* Smooth, so that little is lost. */
static inline int jpeg_value(int x, int y, int channel) {
    return 20 + 40 * channel + (channel % 2 == 0 ? 3 * x : 5 * y);
}

static inline void write_jpeg(const char* path, const jpeg_kind* kind) {
    remove(path);
    FILE* stream = fopen(path, "wb");
    assert_non_null(stream);
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, stream);
    const int channels = kind->from == JCS_GRAYSCALE ? 1 : kind->from == JCS_CMYK ? 4 : kind->from == JCS_RGB ? 3 : 2;
    jpeg.image_width = MADE_WIDTH;
    jpeg.image_height = MADE_HEIGHT;
    jpeg.input_components = channels;
    jpeg.in_color_space = kind->from;
    jpeg_set_defaults(&jpeg);
    jpeg_set_colorspace(&jpeg, kind->to);
    jpeg_set_quality(&jpeg, 100, TRUE);
    for (int c = 0; c < jpeg.num_components; ++c) jpeg.comp_info[c].h_samp_factor = jpeg.comp_info[c].v_samp_factor = 1;
    if (kind->progressive) jpeg_simple_progression(&jpeg);
    jpeg_scan_info scans[MANY_SCANS];
    plan_many_scans(scans);
    if (kind->many_scans) {
        jpeg.scan_info = scans;
        jpeg.num_scans = MANY_SCANS;
    }
    if (kind->without_adobe_marker) jpeg.write_Adobe_marker = FALSE;
    jpeg_start_compress(&jpeg, TRUE);
    for (int y = 0; y < MADE_HEIGHT; ++y) {
        JSAMPLE values[MADE_WIDTH * 4];
        JSAMPROW row = values;
        for (int i = 0; i < MADE_WIDTH * channels; ++i) values[i] = (JSAMPLE)jpeg_value(i / channels, y, i % channels);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    assert_int_equal(fclose(stream), 0);
}

#endif
