/* Merging renderings: weights, variances, frames, and what may not be merged. */
#include "checks.h"

#include "cli/images/merge_images.h"
#include "cli/images/merge_seeds.h"

enum { PIXELS = 6 };

static const char* const names[] = {"R", "G", "B", "variance.R", "depth.Z", "samples.N"};

/* 3 x 2 pixels whose channels hold first, first + 1, ...; without samples.N when spp is given. */
static ty_image* piece(ty_context* context, float first, double spp, const char* seed) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create(context, 3, 2, spp > 0 ? 5 : 6, names, &image), TY_OK);
    for (int c = 0; c < ty_image_channel_count(image); ++c)
        for (int i = 0; i < PIXELS; ++i) ty_image_plane(image, c)[i] = first + (float)(c * PIXELS + i);
    ty_image_set_text(image, "tyndall.scene", "0123456789abcdef");
    ty_image_set_text(image, "tyndall.method", "path");
    ty_image_set_text(image, "tyndall.seed", seed);
    ty_image_set_number(image, "tyndall.seconds", 1.5);
    if (spp > 0) ty_image_set_number(image, "tyndall.spp", spp);
    return image;
}

static ty_image* merged(ty_context* context, ty_image* a, ty_image* b) {
    const cli_piece pieces[] = {{"a.exr", a}, {"b.exr", b}};
    char message[CLI_MESSAGE_SIZE] = "";
    ty_image* out = NULL;
    if (cli_merge_images(context, 2, pieces, &out, message) != TY_OK) fail_msg("%s", message);
    return out;
}

static float value(const ty_image* image, const char* name, int pixel) {
    const float* plane = ty_image_plane_const(image, ty_image_find_channel(image, name));
    assert_non_null(plane);
    return plane[pixel];
}

static void weights_are_samples(void** state) {
    ty_image* a = piece(*state, 1, 1, "7");
    ty_image* b = piece(*state, 5, 3, "8");
    ty_image_plane(b, 4)[2] = 0; /* sees no surface */
    ty_image* out = merged(*state, a, b);
    assert_int_equal(ty_image_find_channel(out, "samples.N"), -1);
    for (int i = 0; i < PIXELS; ++i) {
        assert_close((double)value(out, "G", i), (1 * (1 + 6 + i) + 3 * (5 + 6 + i)) / 4.0, 1e-6);
        assert_close((double)value(out, "variance.R", i), (1 * (1 + 18 + i) + 9 * (5 + 18 + i)) / 16.0, 1e-5);
    }
    assert_close((double)value(out, "depth.Z", 1), (1 * 26 + 3 * 30) / 4.0, 1e-5);
    assert_close((double)value(out, "depth.Z", 2), 27, 0);
    assert_string_equal(ty_image_get_metadata(out, "tyndall.seed"), "7, 8");
    assert_string_equal(ty_image_get_metadata(out, "tyndall.spp"), "4");
    assert_string_equal(ty_image_get_metadata(out, "tyndall.seconds"), "3");
    ty_image_destroy(out);
    ty_image_destroy(a);
    ty_image_destroy(b);
}

/* Partial images: each pixel weighs what it has; none has no say. */
static void pixels_weigh_by_themselves(void** state) {
    ty_image* a = piece(*state, 1, 0, "7");
    ty_image* b = piece(*state, 5, 2, "8");
    float* samples = ty_image_plane(a, 5);
    for (int i = 0; i < PIXELS; ++i) samples[i] = (float)i;
    ty_image* out = merged(*state, a, b);
    for (int i = 0; i < PIXELS; ++i) {
        assert_close((double)value(out, "R", i), (i * (1.0 + i) + 2 * (5.0 + i)) / (i + 2.0), 1e-6);
        assert_close((double)value(out, "samples.N", i), i + 2, 0);
    }
    assert_string_equal(ty_image_get_metadata(out, "tyndall.spp"), "4.5");
    ty_image_destroy(out);
    ty_image_destroy(a);
    ty_image_destroy(b);
}

/* Crops of one frame, side by side and with a gap: where they are alone their bits stay. */
static void crops_are_put_in_place(void** state) {
    ty_image* a = piece(*state, 0.1f, 3, "7");
    ty_image* b = piece(*state, 0.7f, 3, "7");
    assert_int_equal(ty_image_set_frame(a, 1, 2, 10, 9), TY_OK);
    assert_int_equal(ty_image_set_frame(b, 5, 3, 10, 9), TY_OK);
    ty_image* out = merged(*state, a, b);
    int32_t frame[4];
    ty_image_get_frame(out, frame);
    assert_true(frame[0] == 1 && frame[1] == 2 && frame[2] == 10 && frame[3] == 9);
    assert_int_equal(ty_image_width(out), 7);
    assert_int_equal(ty_image_height(out), 3);
    for (int i = 0; i < PIXELS; ++i) {
        const int x = i % 3, y = i / 3;
        for (int c = 0; c < 5; ++c) {
            assert_true(value(out, names[c], 7 * y + x) == value(a, names[c], i));
            assert_true(value(out, names[c], 7 * (y + 1) + x + 4) == value(b, names[c], i));
        }
        assert_true(value(out, "samples.N", 7 * y + x) == 3);
    }
    assert_true(value(out, "samples.N", 3) == 0 && value(out, "R", 3) == 0);
    assert_string_equal(ty_image_get_metadata(out, "tyndall.seed"), "7");
    ty_image_destroy(out);
    ty_image_destroy(a);
    ty_image_destroy(b);
}

static void normals_stay_normals(void** state) {
    static const char* const channels[] = {"R", "G", "B", "normal.X", "normal.Y", "normal.Z"};
    ty_image* images[2];
    for (int k = 0; k < 2; ++k) {
        assert_int_equal(ty_image_create(*state, 1, 1, 6, channels, &images[k]), TY_OK);
        ty_image_plane(images[k], 3 + k)[0] = 1;
        ty_image_set_text(images[k], "tyndall.scene", "s");
        ty_image_set_text(images[k], "tyndall.method", "path");
        ty_image_set_text(images[k], "tyndall.seed", k == 0 ? "0" : "1");
        ty_image_set_number(images[k], "tyndall.spp", 2);
    }
    ty_image* out = merged(*state, images[0], images[1]);
    assert_close((double)value(out, "normal.X", 0), sqrt(0.5), 1e-7);
    assert_close((double)value(out, "normal.Y", 0), sqrt(0.5), 1e-7);
    ty_image_destroy(out);
    for (int k = 0; k < 2; ++k) ty_image_destroy(images[k]);
}

/* Takes over both images. */
static void refused(ty_context* context, ty_image* a, ty_image* b, const char* words) {
    const cli_piece pieces[] = {{"a.exr", a}, {"b.exr", b}};
    char message[CLI_MESSAGE_SIZE] = "";
    ty_image* out = NULL;
    assert_int_equal(cli_merge_images(context, 2, pieces, &out, message), TY_ERROR_INPUT);
    if (strstr(message, words) == NULL) fail_msg("\"%s\" does not say \"%s\"", message, words);
    assert_null(out);
    ty_image_destroy(a);
    ty_image_destroy(b);
}

static void strangers_are_refused(void** state) {
    ty_image* b = piece(*state, 2, 1, "7, 18446744073709551615");
    refused(*state, piece(*state, 1, 1, "1, 18446744073709551615"), b, "b.exr: it shares seed 18446744073709551615");
    b = piece(*state, 2, 1, "x");
    refused(*state, piece(*state, 1, 1, "1"), b, "b.exr: tyndall.seed is no list");
    b = piece(*state, 2, 1, "2");
    ty_image_set_text(b, "tyndall.scene", "fedcba9876543210");
    refused(*state, piece(*state, 1, 1, "1"), b, "b.exr: tyndall.scene is fedcba9876543210, and that of a.exr");
    b = piece(*state, 2, 1, "2");
    ty_image_set_text(b, "tyndall.method", "fld");
    refused(*state, piece(*state, 1, 1, "1"), b, "b.exr: tyndall.method is fld");
    b = piece(*state, 2, 1, "2");
    assert_int_equal(ty_image_set_frame(b, 0, 0, 4, 2), TY_OK);
    refused(*state, piece(*state, 1, 1, "1"), b, "b.exr: the frame is 4 x 2, and that of a.exr is 3 x 2");
    b = piece(*state, 2, 1, "2");
    ty_image_set_text(b, "tyndall.spp", "many");
    refused(*state, piece(*state, 1, 1, "1"), b, "b.exr: neither samples.N nor tyndall.spp");
    ty_image_create_rgb(*state, 3, 2, &b);
    refused(*state, piece(*state, 1, 1, "1"), b, "b.exr: it has no tyndall.scene");
}

static void seeds_are_listed_once(void** state) {
    (void)state;
    cli_seeds seeds = {0}, others = {0};
    uint64_t shared = 0;
    assert_true(cli_seeds_add(&seeds, "3, 1"));
    assert_true(cli_seeds_add(&seeds, "1,4, 18446744073709551615"));
    char* text = cli_seeds_text(&seeds);
    assert_string_equal(text, "3, 1, 4, 18446744073709551615");
    free(text);
    assert_true(cli_seeds_add(&others, "5, 6"));
    assert_false(cli_seeds_shared(&seeds, &others, &shared));
    assert_true(cli_seeds_add(&others, "4"));
    assert_true(cli_seeds_shared(&seeds, &others, &shared));
    assert_int_equal(shared, 4);
    static const char* const wrong[] = {"", "1,", ",1", "1,,2", "-1", "1.5", "18446744073709551616", "1 2"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) assert_false(cli_seeds_add(&others, wrong[i]));
    cli_seeds_free(&seeds);
    cli_seeds_free(&others);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_are_samples),    cmocka_unit_test(pixels_weigh_by_themselves),
        cmocka_unit_test(crops_are_put_in_place), cmocka_unit_test(normals_stay_normals),
        cmocka_unit_test(strangers_are_refused),  cmocka_unit_test(seeds_are_listed_once),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
