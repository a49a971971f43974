/* PNG and JPEG in: images, raw images, textures; 16-bit PNG out. */
#include "image_maker.h"
#include "strict_fixture.h"

#include "base/context.h"
#include "io/images/image_file.h"

#include <tyndall/io.h>

#include <math.h>

/* Values that a reader should find: 1 to 4 channels of values up to *max. */
static int expected_pixel(const png_kind* kind, int x, int y, uint32_t pixel[4], uint32_t* max) {
    *max = kind->depth == 16 ? 65535 : 255;
    if (kind->colour == PNG_COLOR_TYPE_PALETTE) {
        const uint32_t entry = png_value(kind, x, y, 0);
        const png_color colour = palette_entry(entry);
        const uint32_t found[4] = {colour.red, colour.green, colour.blue, palette_alpha(entry)};
        memcpy(pixel, found, sizeof found);
        return kind->transparent ? 4 : 3;
    }
    const int channels = png_file_channels(kind->colour);
    bool clear = kind->transparent;
    for (int c = 0; c < channels; ++c) {
        const uint32_t value = png_value(kind, x, y, c);
        clear = clear && value == png_value(kind, 0, 0, c);
        pixel[c] = value * (*max / ((1u << kind->depth) - 1));
    }
    if (!kind->transparent) return channels;
    pixel[channels] = clear ? 0 : *max;
    return channels + 1;
}

static double linear(double x) {
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static const char* const channel_names[5][4] = {{0}, {"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};

static void check_channel(const ty_image* image, const ty_image* raw, const png_kind* kind, int c, int channels) {
    const float* decoded = ty_image_plane_const(image, ty_image_find_channel(image, channel_names[channels][c]));
    const float* plain = ty_image_plane_const(raw, ty_image_find_channel(raw, channel_names[channels][c]));
    assert_non_null(decoded);
    assert_non_null(plain);
    for (int i = 0; i < MADE_WIDTH * MADE_HEIGHT; ++i) {
        uint32_t pixel[4], max;
        expected_pixel(kind, i % MADE_WIDTH, i / MADE_WIDTH, pixel, &max);
        const bool alpha = channels % 2 == 0 && c == channels - 1;
        const float value = (float)pixel[c] / (float)max;
        assert_true(plain[i] == value);
        assert_true(fabs(decoded[i] - (alpha ? (double)value : linear(value))) < 1e-6);
    }
}

static void check_texture(const char* path, const png_kind* kind, int channels) {
    size_t size = 0;
    uint8_t* bytes = get_file(path, &size);
    int32_t width = 0, height = 0;
    uint8_t* rgba8 = NULL;
    assert_int_equal(ty_decode_rgba8(context, path, bytes, size, &width, &height, &rgba8), TY_OK);
    free(bytes);
    assert_int_equal(width, MADE_WIDTH);
    assert_int_equal(height, MADE_HEIGHT);
    for (int i = 0; i < MADE_WIDTH * MADE_HEIGHT; ++i) {
        uint32_t pixel[4], max;
        expected_pixel(kind, i % MADE_WIDTH, i / MADE_WIDTH, pixel, &max);
        for (int c = 0; c < 4; ++c) {
            const bool has_alpha = channels % 2 == 0;
            const uint32_t value = c == 3 ? (has_alpha ? pixel[channels - 1] : max) : pixel[channels < 3 ? 0 : c];
            assert_int_equal(rgba8[4 * i + c], (uint32_t)floor(255.0 * value / max + 0.5));
        }
    }
    ty_free_array(context, rgba8, (size_t)width * (size_t)height, 4);
}

static void check_kind(const png_kind* kind) {
    write_kind("kind.png", kind);
    uint32_t pixel[4], max;
    const int channels = expected_pixel(kind, 0, 0, pixel, &max);
    ty_image *image = NULL, *raw = NULL;
    assert_int_equal(ty_image_read(context, "kind.png", &image), TY_OK);
    assert_int_equal(ty_image_read_raw(context, "kind.png", &raw), TY_OK);
    assert_int_equal(ty_image_width(image), MADE_WIDTH);
    assert_int_equal(ty_image_height(image), MADE_HEIGHT);
    assert_int_equal(ty_image_channel_count(image), channels);
    const float* planes[3];
    assert_true(ty_image_rgb_planes(image, planes));
    for (int c = 0; c < channels; ++c) check_channel(image, raw, kind, c, channels);
    check_texture("kind.png", kind, channels);
    ty_image_destroy(image);
    ty_image_destroy(raw);
}

static void png_of_every_kind_is_read(void** state) {
    (void)state;
    static const struct {
        int colour, depths[6];
        bool may_be_transparent;
    } colours[] = {
        {PNG_COLOR_TYPE_GRAY, {1, 2, 4, 8, 16}, true}, {PNG_COLOR_TYPE_GRAY_ALPHA, {8, 16}, false},
        {PNG_COLOR_TYPE_PALETTE, {1, 2, 4, 8}, true},  {PNG_COLOR_TYPE_RGB, {8, 16}, true},
        {PNG_COLOR_TYPE_RGB_ALPHA, {8, 16}, false},
    };
    for (size_t i = 0; i < sizeof colours / sizeof *colours; ++i)
        for (const int* depth = colours[i].depths; *depth != 0; ++depth)
            for (int variant = 0; variant < (colours[i].may_be_transparent ? 4 : 2); ++variant) {
                const png_kind kind = {colours[i].colour, *depth, variant % 2 == 1, variant >= 2};
                check_kind(&kind);
            }
}

static void whole_samples_are_exact(void** state) {
    (void)state;
    static const char* const name = "depth";
    ty_image *image = NULL, *back = NULL;
    int32_t largest = -1;
    assert_int_equal(ty_image_create(context, 256, 256, 1, &name, &image), TY_OK);
    for (int i = 0; i < 65536; ++i) ty_image_plane(image, 0)[i] = (float)i;
    assert_int_equal(ty_image_write_png16(context, image, 0, 1, "whole.png"), TY_OK);
    assert_int_equal(ty_image_read_whole(context, "whole.png", &back, &largest), TY_OK);
    assert_int_equal(largest, 65535);
    for (int i = 0; i < 65536; ++i) assert_true(ty_image_plane_const(back, 0)[i] == (float)i);
    ty_image_destroy(back);
    assert_int_equal(ty_image_write_png(context, image, 0, TY_TONE_CLIP, "bytes.png"), TY_OK);
    assert_int_equal(ty_image_read_whole(context, "bytes.png", &back, &largest), TY_OK);
    assert_int_equal(largest, 255);
    assert_true(ty_image_plane_const(back, 0)[0] == 0 && ty_image_plane_const(back, 0)[1] == 255);
    ty_image_destroy(back);
    assert_int_equal(ty_image_write_exr(context, image, "whole.exr"), TY_OK);
    assert_int_equal(ty_image_read_whole(context, "whole.exr", &back, &largest), TY_OK);
    assert_int_equal(largest, 0);
    assert_true(ty_image_plane_const(back, 0)[65535] == 65535);
    ty_image_destroy(back);
    ty_image_destroy(image);
}

static void sixteen_bits_map_to_one(void** state) {
    (void)state;
    static const char* const names[] = {"depth", "mask"};
    static const float values[] = {0, 1, 0.5f, 2, -1, NAN, INFINITY, 65534.4f / 65535, 0.25f};
    static const float expected[] = {0, 65535, 32768, 65535, 0, 0, 65535, 65534, 16384};
    ty_image *image = NULL, *back = NULL;
    assert_int_equal(ty_image_create(context, 9, 1, 2, names, &image), TY_OK);
    memcpy(ty_image_plane(image, 1), values, sizeof values);
    assert_int_equal(ty_image_write_png16(context, image, 1, 65535, "words.png"), TY_OK);
    assert_int_equal(ty_image_read_raw(context, "words.png", &back), TY_OK);
    assert_int_equal(ty_image_channel_count(back), 1);
    for (int i = 0; i < 9; ++i) assert_true(ty_image_plane_const(back, 0)[i] == expected[i] / 65535);
    ty_image_destroy(back);
    assert_failed(context, ty_image_write_png16(context, image, 2, 1, "words.png"), TY_ERROR_ARGUMENT, "words.png",
                  "channel 2");
    assert_failed(context, ty_image_write_png16(context, image, 0, NAN, "words.png"), TY_ERROR_ARGUMENT, "words.png",
                  "finite");
    assert_failed(context, ty_image_write_png16(context, image, 0, 1, "no/words.png"), TY_ERROR_FILE, "no/words.png",
                  "No such file");
    ty_image_destroy(image);
}

/* The colour that a pixel of a file of CMYK values should have. */
static double ink_colour(int x, int y, int c, bool inverted) {
    const double ink = jpeg_value(x, y, c), black = jpeg_value(x, y, 3);
    return inverted ? ink * black / 255 : (255 - ink) * (255 - black) / 255;
}

static void check_jpeg(const jpeg_kind* kind) {
    write_jpeg("made.jpg", kind);
    ty_image* raw = NULL;
    assert_int_equal(ty_image_read_raw(context, "made.jpg", &raw), TY_OK);
    assert_int_equal(ty_image_width(raw), MADE_WIDTH);
    assert_int_equal(ty_image_height(raw), MADE_HEIGHT);
    assert_int_equal(ty_image_channel_count(raw), kind->from == JCS_GRAYSCALE ? 1 : 3);
    const float* planes[3];
    assert_true(ty_image_rgb_planes(raw, planes));
    for (int i = 0; i < MADE_WIDTH * MADE_HEIGHT; ++i)
        for (int c = 0; c < 3; ++c) {
            const int x = i % MADE_WIDTH, y = i / MADE_WIDTH;
            const double expected = kind->from == JCS_CMYK ? ink_colour(x, y, c, !kind->without_adobe_marker)
                                                           : jpeg_value(x, y, kind->from == JCS_GRAYSCALE ? 0 : c);
            const double value = 255 * (double)planes[c][i];
            if (!(fabs(value - expected) < 5)) fail_msg("%d at %d, %d: %g, not %g", c, x, y, value, expected);
        }
    ty_image_destroy(raw);
}

static void jpeg_of_every_kind_is_read(void** state) {
    (void)state;
    static const jpeg_kind kinds[] = {
        {.from = JCS_GRAYSCALE, .to = JCS_GRAYSCALE},
        {.from = JCS_RGB, .to = JCS_YCbCr},
        {.from = JCS_RGB, .to = JCS_YCbCr, .progressive = true},
        {.from = JCS_RGB, .to = JCS_RGB},
        {.from = JCS_CMYK, .to = JCS_CMYK},
        {.from = JCS_CMYK, .to = JCS_CMYK, .progressive = true, .without_adobe_marker = true},
        {.from = JCS_CMYK, .to = JCS_YCCK}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) check_jpeg(&kinds[i]);
}

static void jpeg_is_decoded_to_linear_and_to_texels(void** state) {
    (void)state;
    const jpeg_kind kind = {.from = JCS_RGB, .to = JCS_YCbCr};
    write_jpeg("made.jpg", &kind);
    ty_image *image = NULL, *raw = NULL;
    assert_int_equal(ty_image_read(context, "made.jpg", &image), TY_OK);
    assert_int_equal(ty_image_read_raw(context, "made.jpg", &raw), TY_OK);
    size_t size = 0;
    uint8_t *bytes = get_file("made.jpg", &size), *rgba8 = NULL;
    int32_t width = 0, height = 0;
    assert_int_equal(ty_decode_rgba8(context, "made.jpg", bytes, size, &width, &height, &rgba8), TY_OK);
    free(bytes);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < MADE_WIDTH * MADE_HEIGHT; ++i) {
            const double coded = (double)ty_image_plane_const(raw, c)[i];
            assert_true(fabs((double)ty_image_plane_const(image, c)[i] - linear(coded)) < 1e-6);
            assert_int_equal(rgba8[4 * i + c], (int)(255 * coded + 0.5));
            assert_int_equal(rgba8[4 * i + 3], 255);
        }
    ty_free_array(context, rgba8, (size_t)width * (size_t)height, 4);
    ty_image_destroy(image);
    ty_image_destroy(raw);
}

/* Reads bytes as a file; any failure must name the file and hand out nothing. */
static ty_result read_bytes(const uint8_t* bytes, size_t size) {
    ty_image* image = NULL;
    const ty_result result = ty_read_image_bytes(context, "torture.bin", bytes, size, TY_SAMPLES_LINEAR, NULL, &image);
    assert_int_equal(result == TY_OK, image != NULL);
    const char* message = ty_take_error(context);
    if (result != TY_OK && result != TY_ERROR_MEMORY) assert_non_null(strstr(message, "torture.bin"));
    ty_image_destroy(image);
    return result;
}

/* Every beginning of the file is an error; flipped bits never do harm, and PNG's checksums find each. */
static void torture(const char* path, bool checked) {
    size_t size;
    uint8_t* bytes = get_file(path, &size);
    assert_int_equal(read_bytes(bytes, size), TY_OK);
    for (size_t length = 0; length < size; ++length) {
        uint8_t* beginning = malloc(length + 1); /* of its own, so that sanitizers see reading beyond it */
        memcpy(beginning, bytes, length);
        assert_int_equal(read_bytes(beginning, length), TY_ERROR_INPUT);
        free(beginning);
    }
    for (size_t i = 0; i < 8 * size; i += 5) {
        bytes[i / 8] ^= (uint8_t)(1 << i % 8);
        const ty_result result = read_bytes(bytes, size);
        if (checked) assert_int_not_equal(result, TY_OK);
        bytes[i / 8] ^= (uint8_t)(1 << i % 8);
    }
    free(bytes);
}

static void broken_samples_are_refused(void** state) {
    (void)state;
    const png_kind palette = {PNG_COLOR_TYPE_PALETTE, 4, true, true}, rgb = {PNG_COLOR_TYPE_RGB, 16, false, false};
    const jpeg_kind sequential = {.from = JCS_RGB, .to = JCS_YCbCr},
                    progressive = {.from = JCS_CMYK, .to = JCS_YCCK, .progressive = true};
    write_kind("torture.png", &palette);
    torture("torture.png", true);
    write_kind("torture.png", &rgb);
    torture("torture.png", true);
    write_jpeg("torture.jpg", &sequential);
    torture("torture.jpg", false);
    write_jpeg("torture.jpg", &progressive);
    torture("torture.jpg", false);
}

static ty_result read_and_destroy(ty_context* strict, void* path) {
    ty_image* image = NULL;
    const ty_result result = ty_image_read(strict, path, &image);
    ty_image_destroy(image);
    return result;
}

static void short_memory_is_survived(void** state) {
    (void)state;
    const png_kind kind = {PNG_COLOR_TYPE_RGB, 16, false, false};
    const jpeg_kind jpeg = {.from = JCS_RGB, .to = JCS_YCbCr};
    static char paths[][16] = {"memory.png", "memory.jpg"};
    write_kind(paths[0], &kind);
    write_jpeg(paths[1], &jpeg);
    for (int i = 0; i < 2; ++i) assert_true(check_short_memory(context, &memory, read_and_destroy, paths[i]) > 5);
}

static void real_photographs_and_depths_are_read(void** state) {
    (void)state;
    char path[1024];
    ty_image* image = NULL;
    assert_int_equal(ty_image_read(context, data_path("rgbd/tum_fr1_color.png", path), &image), TY_OK);
    assert_int_equal(ty_image_channel_count(image), 3);
    assert_true(fabs((double)ty_image_plane_const(image, 0)[0] - linear(158 / 255.0)) < 1e-6);
    ty_image_destroy(image);
    assert_int_equal(ty_image_read_raw(context, data_path("rgbd/tum_fr1_depth.png", path), &image), TY_OK);
    assert_int_equal(ty_image_width(image), 640);
    assert_int_equal(ty_image_height(image), 480);
    /* 5000 to a metre: an office */
    double farthest = 0;
    for (int i = 0; i < 640 * 480; ++i)
        farthest = fmax(farthest, 65535 / 5000.0 * (double)ty_image_plane_const(image, 0)[i]);
    assert_true(farthest > 2 && farthest < 10);
    ty_image_destroy(image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(png_of_every_kind_is_read),
        cmocka_unit_test(whole_samples_are_exact),
        cmocka_unit_test(sixteen_bits_map_to_one),
        cmocka_unit_test(jpeg_of_every_kind_is_read),
        cmocka_unit_test(jpeg_is_decoded_to_linear_and_to_texels),
        cmocka_unit_test(broken_samples_are_refused),
        cmocka_unit_test(short_memory_is_survived),
        cmocka_unit_test(real_photographs_and_depths_are_read),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
