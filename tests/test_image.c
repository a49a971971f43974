/* Images in memory: channels, layers, frames, metadata, comparison, tone mapping. */
#include <tyndall/io.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static ty_context* context;

static int start(void** state) {
    (void)state;
    const ty_context_def def = ty_default_context_def();
    return ty_context_create(&def, &context) == TY_OK ? 0 : -1;
}

static int stop(void** state) {
    (void)state;
    ty_context_destroy(context);
    return 0;
}

static void assert_close(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance)) fail_msg("%.17g is not %.17g +- %g", value, expected, tolerance);
}

static ty_image* make_rgb(int32_t width, int32_t height) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create_rgb(context, width, height, &image), TY_OK);
    return image;
}

static void channels_have_names_and_planes(void** state) {
    (void)state;
    static const char* const names[] = {"R", "depth.Z", "a"};
    ty_image* image = NULL;
    assert_int_equal(ty_image_create(context, 5, 3, 3, names, &image), TY_OK);
    assert_int_equal(ty_image_width(image), 5);
    assert_int_equal(ty_image_height(image), 3);
    assert_int_equal(ty_image_channel_count(image), 3);
    assert_string_equal(ty_image_channel_name(image, 1), "depth.Z");
    assert_null(ty_image_channel_name(image, 3));
    assert_int_equal(ty_image_find_channel(image, "a"), 2);
    assert_int_equal(ty_image_find_channel(image, "A"), -1);
    assert_null(ty_image_plane(image, 3));
    for (int c = 0; c < 3; ++c) {
        float* plane = ty_image_plane(image, c);
        for (int i = 0; i < 15; ++i) {
            assert_true(plane[i] == 0);
            plane[i] = (float)(100 * c + i);
        }
    }
    for (int c = 0; c < 3; ++c) assert_true(ty_image_plane_const(image, c)[14] == (float)(100 * c + 14));
    const float* planes[3];
    assert_false(ty_image_rgb_planes(image, planes));
    ty_image_destroy(image);
}

static void one_channel_stands_for_three(void** state) {
    (void)state;
    static const char* const name[] = {"luminance"};
    ty_image* image = NULL;
    assert_int_equal(ty_image_create(context, 2, 2, 1, name, &image), TY_OK);
    const float* planes[3];
    assert_true(ty_image_rgb_planes(image, planes));
    assert_ptr_equal(planes[0], ty_image_plane_const(image, 0));
    assert_ptr_equal(planes[2], planes[0]);
    ty_image_destroy(image);
}

static void wrong_arguments_are_refused(void** state) {
    (void)state;
    static const char* const twice[] = {"R", "R"};
    static const char* const empty[] = {""};
    static const char* const good[] = {"Y"};
    char long_name[256];
    memset(long_name, 'x', 255);
    long_name[255] = '\0';
    const char* const too_long[] = {long_name};
    ty_image* image = NULL;
    assert_int_equal(ty_image_create(context, 2, 2, 2, twice, &image), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_image_create(context, 2, 2, 1, empty, &image), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_image_create(context, 2, 2, 1, too_long, &image), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_image_create(context, 0, 2, 1, good, &image), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_image_create(context, 2, 65537, 1, good, &image), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_image_create(context, 2, 2, 0, good, &image), TY_ERROR_ARGUMENT);
    assert_null(image);
    long_name[254] = '\0';
    assert_int_equal(ty_image_create(context, 2, 2, 1, too_long, &image), TY_OK);
    ty_image_destroy(image);
    ty_image_destroy(NULL);
}

static void metadata_is_kept_and_replaced(void** state) {
    (void)state;
    ty_image* image = make_rgb(2, 2);
    assert_int_equal(ty_image_set_text(image, "method", "path"), TY_OK);
    assert_int_equal(ty_image_set_number(image, "spp", 64), TY_OK);
    assert_int_equal(ty_image_set_number(image, "tenth", 0.1), TY_OK);
    assert_int_equal(ty_image_set_number(image, "third", 1.0 / 3.0), TY_OK);
    assert_int_equal(ty_image_set_number(image, "tiny", 5e-324), TY_OK);
    assert_string_equal(ty_image_get_metadata(image, "method"), "path");
    assert_string_equal(ty_image_get_metadata(image, "spp"), "64");
    assert_string_equal(ty_image_get_metadata(image, "tenth"), "0.1");
    assert_true(strtod(ty_image_get_metadata(image, "third"), NULL) == 1.0 / 3.0);
    assert_string_equal(ty_image_get_metadata(image, "tiny"), "5e-324");
    assert_int_equal(ty_image_metadata_count(image), 5);
    assert_int_equal(ty_image_set_text(image, "spp", "many"), TY_OK);
    assert_int_equal(ty_image_metadata_count(image), 5);
    assert_string_equal(ty_image_get_metadata(image, "spp"), "many");
    assert_string_equal(ty_image_metadata_key(image, 1), "spp");
    assert_null(ty_image_metadata_key(image, 5));
    assert_false(ty_image_metadata_is_number(image, 0)); /* method */
    assert_false(ty_image_metadata_is_number(image, 1)); /* spp, now many */
    assert_true(ty_image_metadata_is_number(image, 2));
    assert_false(ty_image_metadata_is_number(image, 5));
    assert_null(ty_image_get_metadata(image, "absent"));
    static const char* const wrong[] = {"", "with space", "compression", "dataWindow",
                                        "a2345678901234567890123456789012"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        assert_int_equal(ty_image_set_text(image, wrong[i], "x"), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_image_set_text(image, "a234567890123456789012345678901", "x"), TY_OK);
    ty_image_destroy(image);
}

/* Fills channel c with mean + amplitude * (+-1 in a checkerboard). */
static void checker(ty_image* image, int c, float mean, float amplitude) {
    const int width = ty_image_width(image), height = ty_image_height(image);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            ty_image_plane(image, c)[y * width + x] = mean + ((x + y) % 2 == 0 ? amplitude : -amplitude);
}

static void comparison_meets_closed_forms(void** state) {
    (void)state;
    ty_image *a = make_rgb(16, 8), *b = make_rgb(16, 8);
    static const float mean_a[3] = {2, 3, 4}, mean_b[3] = {1, 3, 8}, amplitude[3] = {0.5f, 0.25f, 0};
    for (int c = 0; c < 3; ++c) {
        checker(a, c, mean_a[c], amplitude[c]);
        checker(b, c, mean_b[c], 0);
    }
    ty_difference d;
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_OK);
    double all_square = 0, all_relative = 0;
    const double all_b = (1 + 3 + 8) / 3.0;
    for (int c = 0; c < 3; ++c) {
        const double shift = mean_a[c] - mean_b[c];
        const double square = shift * shift + amplitude[c] * amplitude[c];
        assert_close(d.mean_ratio[c], mean_a[c] / mean_b[c], 1e-12);
        assert_close(d.rmse[c], sqrt(square), 1e-12);
        assert_close(d.relative_rmse[c], sqrt(square) / mean_b[c], 1e-12);
        assert_close(d.rel_mse[c], square / (1.01 * mean_b[c] * mean_b[c]), 1e-12);
        all_square += square / 3;
        all_relative += square / (mean_b[c] * mean_b[c] + 0.01 * all_b * all_b) / 3;
    }
    assert_close(d.mean_ratio[3], 9.0 / 12.0, 1e-12);
    assert_close(d.rmse[3], sqrt(all_square), 1e-12);
    assert_close(d.relative_rmse[3], sqrt(all_square) / all_b, 1e-12);
    assert_close(d.rel_mse[3], all_relative, 1e-12);
    assert_int_equal(d.not_finite, 0);
    assert_int_equal(d.differing, 3 * 16 * 8);

    /* Over blocks of two by two the checkerboard averages out; the mean stays. */
    assert_int_equal(ty_image_compare(context, a, b, 2, &d), TY_OK);
    assert_close(d.rmse[0], 1, 1e-12);
    assert_close(d.rmse[1], 0, 1e-12);
    assert_close(d.mean_ratio[0], 2, 1e-12);
    ty_image_destroy(a);
    ty_image_destroy(b);
}

static void partial_blocks_are_left_out(void** state) {
    (void)state;
    ty_image *a = make_rgb(5, 3), *b = make_rgb(5, 3);
    for (int c = 0; c < 3; ++c) {
        checker(a, c, 1, 0);
        checker(b, c, 1, 0);
        ty_image_plane(a, c)[4] = 100;
        ty_image_plane(a, c)[2 * 5] = 100;
    }
    ty_difference d;
    assert_int_equal(ty_image_compare(context, a, b, 2, &d), TY_OK);
    assert_true(d.rmse[3] == 0 && d.mean_ratio[3] == 1);
    assert_int_equal(d.differing, 6);
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_OK);
    assert_true(d.rmse[3] > 1);
    assert_int_equal(ty_image_compare(context, a, b, 4, &d), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_image_compare(context, a, b, 0, &d), TY_ERROR_ARGUMENT);
    ty_image_destroy(a);
    ty_image_destroy(b);
}

static void values_that_are_not_finite_are_left_out(void** state) {
    (void)state;
    ty_image *a = make_rgb(4, 4), *b = make_rgb(4, 4);
    for (int c = 0; c < 3; ++c) {
        checker(a, c, 2, 0);
        checker(b, c, 1, 0);
    }
    ty_image_plane(a, 0)[3] = NAN;
    ty_image_plane(b, 1)[7] = INFINITY;
    ty_image_plane(a, 2)[5] = ty_image_plane(b, 2)[5] = NAN;
    ty_difference d;
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_OK);
    assert_int_equal(d.not_finite, 4);
    for (int c = 0; c < 4; ++c) {
        assert_close(d.mean_ratio[c], 2, 1e-12);
        assert_close(d.rmse[c], 1, 1e-12);
    }
    ty_image_destroy(a);
    ty_image_destroy(b);
}

static void equal_and_black_images_have_no_error(void** state) {
    (void)state;
    ty_image *a = make_rgb(4, 4), *b = make_rgb(4, 4), *c = make_rgb(4, 5);
    ty_difference d;
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_OK);
    assert_true(d.mean_ratio[3] == 1 && d.rmse[3] == 0 && d.relative_rmse[3] == 0 && d.rel_mse[3] == 0);
    assert_int_equal(d.differing, 0);
    ty_image_plane(a, 0)[0] = -0.0f;
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_OK);
    assert_int_equal(d.differing, 1);
    assert_int_equal(ty_image_compare(context, a, c, 1, &d), TY_ERROR_ARGUMENT);
    static const char* const names[] = {"X", "Y"};
    ty_image* no_colour = NULL;
    assert_int_equal(ty_image_create(context, 4, 4, 2, names, &no_colour), TY_OK);
    assert_int_equal(ty_image_compare(context, a, no_colour, 1, &d), TY_ERROR_ARGUMENT);
    ty_image_destroy(a);
    ty_image_destroy(b);
    ty_image_destroy(c);
    ty_image_destroy(no_colour);
}

/* Marks each pixel by its place in the frame. */
static float mark(int c, int32_t x, int32_t y) {
    return (float)(10000 * c + 100 * y + x);
}

static ty_image* make_marked(int32_t x, int32_t y, int32_t width, int32_t height) {
    ty_image* image = make_rgb(width, height);
    assert_int_equal(ty_image_set_frame(image, x, y, 20, 10), TY_OK);
    for (int c = 0; c < 3; ++c)
        for (int32_t i = 0; i < width * height; ++i)
            ty_image_plane(image, c)[i] = mark(c, x + i % width, y + i / width);
    return image;
}

static void frames_are_kept_and_checked(void** state) {
    (void)state;
    ty_image* image = make_rgb(5, 3);
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    assert_true(frame[0] == 0 && frame[1] == 0 && frame[2] == 5 && frame[3] == 3);
    static const int32_t wrong[][4] = {{0, 0, 0, 3},
                                       {0, 0, 5, -1},
                                       {0, 0, 65537, 3},
                                       {0, 0, 5, 65537},
                                       {(1 << 20) + 1, 0, 5, 3},
                                       {0, -(1 << 20) - 1, 5, 3}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        assert_int_equal(ty_image_set_frame(image, wrong[i][0], wrong[i][1], wrong[i][2], wrong[i][3]),
                         TY_ERROR_ARGUMENT);
        ty_take_error(context);
    }
    ty_image_get_frame(image, frame);
    assert_true(frame[0] == 0 && frame[1] == 0 && frame[2] == 5 && frame[3] == 3);
    assert_int_equal(ty_image_set_frame(image, -7, 1 << 20, 65536, 1), TY_OK);
    ty_image_get_frame(image, frame);
    assert_true(frame[0] == -7 && frame[1] == 1 << 20 && frame[2] == 65536 && frame[3] == 1);
    ty_image_destroy(image);
}

static void filling_a_frame_cuts_and_pads(void** state) {
    (void)state;
    static const int32_t windows[][4] = {{3, 2, 5, 4},  {-4, -3, 10, 8}, {15, 7, 9, 9}, {-2, -2, 30, 20},
                                         {20, 0, 4, 4}, {-9, 3, 4, 4},   {0, 0, 20, 10}};
    for (size_t i = 0; i < sizeof windows / sizeof *windows; ++i) {
        const int32_t* w = windows[i];
        ty_image *image = make_marked(w[0], w[1], w[2], w[3]), *filled = NULL;
        assert_int_equal(ty_image_set_number(image, "spp", 7), TY_OK);
        assert_int_equal(ty_image_create_full_frame(context, image, &filled), TY_OK);
        assert_int_equal(ty_image_width(filled), 20);
        assert_int_equal(ty_image_height(filled), 10);
        assert_string_equal(ty_image_get_metadata(filled, "spp"), "7");
        assert_int_equal(ty_image_find_channel(filled, "B"), 2);
        for (int c = 0; c < 3; ++c)
            for (int32_t k = 0; k < 200; ++k) {
                const int32_t x = k % 20, y = k / 20;
                const bool inside = x >= w[0] && x < w[0] + w[2] && y >= w[1] && y < w[1] + w[3];
                assert_true(ty_image_plane_const(filled, c)[k] == (inside ? mark(c, x, y) : 0));
            }
        ty_image_destroy(image);
        ty_image_destroy(filled);
    }
}

static void comparison_is_over_the_common_part(void** state) {
    (void)state;
    /* They share x 4..7 and y 2..4; pixels beside that differ. */
    ty_image *a = make_marked(-2, 2, 10, 3), *b = make_marked(4, -1, 9, 12), *c = make_marked(8, 0, 3, 3);
    ty_difference d;
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_OK);
    assert_true(d.differing == 0 && d.rmse[3] == 0 && d.mean_ratio[3] == 1);
    assert_close(d.rel_mse[3], 0, 0);
    /* The pixel at (7, 4) of the frame is in both, that at (8, 4) only in b. */
    ty_image_plane(b, 0)[9 * 5 + 4] = NAN;
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_OK);
    assert_int_equal(d.differing, 0);
    ty_image_plane(a, 1)[10 * 2 + 9] += 6;
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_OK);
    assert_int_equal(d.differing, 1);
    assert_close(d.rmse[1], 6 / sqrt(12), 1e-12);
    assert_close(d.rmse[0], 0, 0);
    assert_int_equal(ty_image_compare(context, a, b, 3, &d), TY_OK);
    assert_close(d.rmse[1], 0, 0); /* blocks begin at (4, 2), so that one of 3 x 3 ends at x 6 */
    assert_int_equal(ty_image_compare(context, a, b, 4, &d), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    assert_int_equal(ty_image_compare(context, a, c, 1, &d), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(context), "no pixel in common"));
    assert_int_equal(ty_image_set_frame(b, 4, -1, 21, 10), TY_OK);
    assert_int_equal(ty_image_compare(context, a, b, 1, &d), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(context), "20 x 10 and 21 x 10"));
    ty_image_destroy(a);
    ty_image_destroy(b);
    ty_image_destroy(c);
}

static void luminance_stands_for_three(void** state) {
    (void)state;
    static const char* const names[] = {"A", "Y"};
    ty_image* image = NULL;
    const float* planes[3];
    assert_int_equal(ty_image_create(context, 2, 2, 2, names, &image), TY_OK);
    assert_true(ty_image_rgb_planes(image, planes));
    for (int c = 0; c < 3; ++c) assert_ptr_equal(planes[c], ty_image_plane_const(image, 1));
    ty_image_destroy(image);
}

static void layers_are_taken_by_name(void** state) {
    (void)state;
    static const char* const names[] = {"R",       "G",      "B", "left.R", "left.G", "left.B", "left.light1.R",
                                        "depth.Z", "lefty.A"};
    ty_image *image = NULL, *layer = NULL;
    assert_int_equal(ty_image_create(context, 3, 2, 9, names, &image), TY_OK);
    for (int c = 0; c < 9; ++c) ty_image_plane(image, c)[5] = (float)c + 1;
    assert_int_equal(ty_image_set_frame(image, 1, -1, 9, 8), TY_OK);
    assert_int_equal(ty_image_set_text(image, "method", "path"), TY_OK);
    static const struct {
        const char* layer;
        int count;
        const char* name;
        float value;
    } cases[] = {{"", 3, "G", 2},
                 {"left", 4, "B", 6},
                 {"left", 4, "light1.R", 7},
                 {"left.light1", 1, "R", 7},
                 {"depth", 1, "Z", 8}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        assert_int_equal(ty_image_create_layer(context, image, cases[i].layer, &layer), TY_OK);
        assert_int_equal(ty_image_channel_count(layer), cases[i].count);
        const int32_t channel = ty_image_find_channel(layer, cases[i].name);
        assert_true(channel >= 0 && ty_image_plane_const(layer, channel)[5] == cases[i].value);
        assert_string_equal(ty_image_get_metadata(layer, "method"), "path");
        int32_t frame[4];
        ty_image_get_frame(layer, frame);
        assert_true(frame[0] == 1 && frame[1] == -1 && frame[2] == 9 && frame[3] == 8);
        ty_image_destroy(layer);
    }
    assert_int_equal(ty_image_create_layer(context, image, "lef", &layer), TY_ERROR_ARGUMENT);
    assert_string_equal(ty_take_error(context), "the image has no layer \"lef\"; it has \"\", \"left\", "
                                                "\"left.light1\", \"depth\", \"lefty\"");
    ty_image_destroy(image);
}

/* More layers than a message can list. */
static void many_layers_are_listed_as_far_as_they_fit(void** state) {
    (void)state;
    enum { COUNT = 40 };
    char texts[COUNT][32];
    const char* names[COUNT];
    for (int i = 0; i < COUNT; ++i) {
        snprintf(texts[i], sizeof texts[i], "a layer of number %d.Z", i);
        names[i] = texts[i];
    }
    ty_image *image = NULL, *layer = NULL;
    assert_int_equal(ty_image_create(context, 1, 1, COUNT, names, &image), TY_OK);
    assert_int_equal(ty_image_create_layer(context, image, "x", &layer), TY_ERROR_ARGUMENT);
    const char* message = ty_take_error(context);
    assert_non_null(strstr(message, "\"a layer of number 3\""));
    assert_string_equal(message + strlen(message) - 5, ", ...");
    ty_image_destroy(image);
}

/* One row of values through the display transform, as bytes. */
static void show(const float* values, int count, double exposure, ty_tone_curve curve, uint8_t* bytes) {
    ty_image* image = make_rgb(count, 1);
    uint8_t* rgb8 = malloc((size_t)count * 3);
    assert_non_null(rgb8);
    for (int c = 0; c < 3; ++c) memcpy(ty_image_plane(image, c), values, (size_t)count * sizeof *values);
    assert_int_equal(ty_image_tonemap(context, image, exposure, curve, rgb8), TY_OK);
    for (int i = 0; i < count; ++i) {
        bytes[i] = rgb8[3 * i];
        assert_true(rgb8[3 * i + 1] == bytes[i] && rgb8[3 * i + 2] == bytes[i]);
    }
    free(rgb8);
    ty_image_destroy(image);
}

static void srgb_values_are_those_of_the_standard(void** state) {
    (void)state;
    static const float values[] = {0, -1, NAN, 0.001f, 0.0031308f, 0.18f, 0.21586f, 0.5f, 1, 2, INFINITY};
    static const uint8_t expected[] = {0, 0, 0, 3, 10, 118, 128, 188, 255, 255, 255};
    uint8_t bytes[11];
    show(values, 11, 0, TY_TONE_CLIP, bytes);
    assert_memory_equal(bytes, expected, sizeof expected);
    static const float quarter[] = {0.125f};
    show(quarter, 1, 2, TY_TONE_CLIP, bytes);
    assert_int_equal(bytes[0], 188);
}

static void filmic_curve_is_monotone_and_bounded(void** state) {
    (void)state;
    enum { COUNT = 4000 };
    static float values[COUNT];
    static uint8_t curved[COUNT], clipped[COUNT];
    for (int i = 0; i < COUNT; ++i) values[i] = (float)exp(-8 + 0.006 * i);
    show(values, COUNT, 0, TY_TONE_FILMIC, curved);
    show(values, COUNT, 0, TY_TONE_CLIP, clipped);
    for (int i = 1; i < COUNT; ++i) assert_true(curved[i] >= curved[i - 1]);
    for (int i = 0; i < COUNT; ++i) {
        if (values[i] <= 0.5f) assert_int_equal(curved[i], clipped[i]);
        if (values[i] > 0.6f) assert_true(curved[i] <= clipped[i]);
    }
    /* Highlights stay apart where clipping would merge them, and infinity is white. */
    static const float bright[] = {1, 2, 8, INFINITY};
    uint8_t bytes[4];
    show(bright, 4, 0, TY_TONE_FILMIC, bytes);
    assert_true(bytes[0] < bytes[1] && bytes[1] < bytes[2] && bytes[2] < bytes[3]);
    assert_int_equal(bytes[3], 255);
    ty_image* image = make_rgb(1, 1);
    assert_int_equal(ty_image_tonemap(context, image, NAN, TY_TONE_FILMIC, bytes), TY_ERROR_ARGUMENT);
    ty_image_destroy(image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(channels_have_names_and_planes),
        cmocka_unit_test(one_channel_stands_for_three),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(metadata_is_kept_and_replaced),
        cmocka_unit_test(comparison_meets_closed_forms),
        cmocka_unit_test(partial_blocks_are_left_out),
        cmocka_unit_test(values_that_are_not_finite_are_left_out),
        cmocka_unit_test(equal_and_black_images_have_no_error),
        cmocka_unit_test(frames_are_kept_and_checked),
        cmocka_unit_test(filling_a_frame_cuts_and_pads),
        cmocka_unit_test(comparison_is_over_the_common_part),
        cmocka_unit_test(luminance_stands_for_three),
        cmocka_unit_test(layers_are_taken_by_name),
        cmocka_unit_test(many_layers_are_listed_as_far_as_they_fit),
        cmocka_unit_test(srgb_values_are_those_of_the_standard),
        cmocka_unit_test(filmic_curve_is_monotone_and_bounded),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
