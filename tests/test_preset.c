/* Media by name: the tables against the published numbers, what the numbers of presets do, and how names match. */
#include "checks.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <tyndall/scene.h>

static void every_row_matches_the_measurements(void** state) {
    (void)state;
    const char* folder = getenv("TYNDALL_DATA");
    char path[512], line[512];
    snprintf(path, sizeof path, "%s/media/measured_media_mm-1.csv", folder != NULL ? folder : TYNDALL_DATA_DIR);
    FILE* file = fopen(path, "r");
    if (file == NULL) {
        print_message("skipped: %s is not there\n", path);
        skip();
    }
    int32_t row = 0;
    assert_non_null(fgets(line, sizeof line, file));
    while (fgets(line, sizeof line, file) != NULL) {
        char name[64];
        double s[3], a[3];
        assert_int_equal(
            sscanf(line, "%63[^,],%lf,%lf,%lf,%lf,%lf,%lf", name, &s[0], &s[1], &s[2], &a[0], &a[1], &a[2]), 7);
        assert_string_equal(ty_medium_preset_name(row++), name);
        ty_medium_def def = ty_default_medium_def();
        assert_true(ty_medium_preset(name, &def));
        for (int c = 0; c < 3; ++c) { /* 1/mm -> 1/m */
            assert_true(fabs(def.sigma_s[c] - 1000 * s[c]) <= 1e-6 * 1000 * s[c]);
            assert_true(fabs(def.sigma_a[c] - 1000 * a[c]) <= 1e-6 * 1000 * a[c]);
        }
    }
    fclose(file);
    assert_int_equal(row, 47);
    for (int32_t i = 0; i < ty_medium_preset_count(); ++i)
        assert_int_equal(ty_medium_preset_kind(i) == TY_PRESET_MEASURED, i < row);
}

static bool near(double value, double expected, double tolerance) {
    return fabs(value - expected) <= tolerance * fabs(expected);
}

/* One of Jerlov's types: absorption and scattering, 1/m, at 600, 625, 550 and 450 nm. */
typedef struct jerlov_row {
    const char* name;
    double absorption[4], scattering[4];
} jerlov_row;

/* Solonenko and Mobley 2015, tables 4 to 8; of 5C at 600 and 625 nm see src/scene/media/preset.c. */
static const jerlov_row jerlov_rows[] = {
    {"Jerlov I", {0.228, 0.295, 0.062, 0.018}, {0.00122, 0.00104, 0.0017, 0.00381}},
    {"Jerlov IA", {0.228, 0.295, 0.0622, 0.0221}, {0.00283, 0.00256, 0.00354, 0.00631}},
    {"Jerlov IB", {0.2278, 0.296, 0.0623, 0.0235}, {0.0488, 0.0468, 0.0536, 0.068}},
    {"Jerlov II", {0.228, 0.296, 0.0622, 0.0241}, {0.309, 0.288, 0.358, 0.504}},
    {"Jerlov III", {0.229, 0.297, 0.0646, 0.0388}, {0.845, 0.788, 0.98, 1.38}},
    {"Jerlov 1C", {0.236, 0.304, 0.076, 0.105}, {0.314, 0.293, 0.365, 0.514}},
    {"Jerlov 3C", {0.239, 0.307, 0.082, 0.154}, {0.916, 0.855, 1.06, 1.5}},
    {"Jerlov 5C", {0.259, 0.327, 0.117, 0.297}, {1.1468, 1.0702, 1.33, 1.87}},
    {"Jerlov 7C", {0.301, 0.367, 0.195, 0.542}, {2.03, 1.89, 2.35, 3.3}},
    {"Jerlov 9C", {0.39, 0.436, 0.348, 0.943}, {2.69, 2.51, 3.12, 4.39}},
};

static void expect_columns(const float rgb[3], const double columns[4]) {
    assert_true(near((double)rgb[0], 0.2 * columns[0] + 0.8 * columns[1], 5e-4));
    assert_true(near((double)rgb[1], columns[2], 1e-6));
    assert_true(near((double)rgb[2], columns[3], 1e-6));
}

static void waters_match_the_tables(void** state) {
    (void)state;
    static const double wavelength[3] = {620, 550, 450};
    ty_medium_def pure = ty_default_medium_def();
    assert_true(ty_medium_preset("pure water", &pure));
    for (int c = 0; c < 3; ++c) {
        assert_true(near((double)pure.sigma_s[c], 0.005826 * pow(400 / wavelength[c], 4.322), 2e-4));
        assert_float_equal(pure.g[c], 0, 0);
    }
    assert_float_equal(pure.sigma_a[0], 0.2755f, 0);
    assert_float_equal(pure.sigma_a[2], 0.00922f, 0);
    for (size_t i = 0; i < sizeof jerlov_rows / sizeof jerlov_rows[0]; ++i) {
        ty_medium_def def = ty_default_medium_def();
        assert_true(ty_medium_preset(jerlov_rows[i].name, &def));
        assert_int_equal(ty_medium_preset_kind(ty_medium_preset_find(jerlov_rows[i].name)), TY_PRESET_WATER);
        expect_columns(def.sigma_a, jerlov_rows[i].absorption);
        expect_columns(def.sigma_s, jerlov_rows[i].scattering);
        float g[3];
        assert_int_equal(ty_medium_mean_cosine(*state, &def, g), TY_OK);
        for (int c = 0; c < 3; ++c) /* molecules and particles together: g is that of the particles, diluted */
            assert_true(near((double)g[c] * def.sigma_s[c], 0.924 * (def.sigma_s[c] - pure.sigma_s[c]), 0.01));
    }
}

static void a_twentieth_of_the_contrast_is_left_at_the_visibility(void** state) {
    (void)state;
    static const char* const names[] = {"fog", "Haze"};
    static const double visibilities[] = {TY_VISIBILITY_MIN, 50, 1234.5, TY_VISIBILITY_MAX};
    for (int i = 0; i < 8; ++i) {
        const double visibility = visibilities[i / 2];
        ty_medium_def def = ty_default_medium_def();
        assert_true(ty_medium_preset_with(names[i % 2], visibility, &def));
        const double green = (double)def.sigma_s[1] + def.sigma_a[1];
        assert_true(near(exp(-green * visibility), 0.05, 1e-5));
    }
    ty_medium_def fog = ty_default_medium_def(), haze = fog;
    assert_true(ty_medium_preset_with("fog", 100, &fog));
    assert_true(ty_medium_preset_with("haze", 100, &haze));
    float mean[3];
    assert_int_equal(ty_medium_mean_cosine(*state, &fog, mean), TY_OK);
    for (int c = 0; c < 3; ++c) {
        static const double wavelength[3] = {620, 550, 450};
        const double extinction = (double)haze.sigma_s[c] + haze.sigma_a[c];
        assert_float_equal(fog.sigma_s[c], fog.sigma_s[1], 0);
        assert_float_equal(fog.sigma_a[c], 0, 0);
        assert_float_equal(fog.g[c], 0, 0);
        assert_float_equal(mean[c], 0.864164f, 1e-5);
        assert_true(near(extinction, 0.029957322735539907 * pow(550 / wavelength[c], 1.3), 1e-4));
        assert_true(near((double)haze.sigma_s[c] / extinction, 0.95, 1e-6));
        assert_float_equal(haze.g[c], 0.7f, 0);
    }
}

static void dilution_goes_from_the_medium_to_water(void** state) {
    (void)state;
    ty_medium_def water = ty_default_medium_def(), milk = water, mixed = water;
    assert_true(ty_medium_preset("pure water", &water));
    assert_true(ty_medium_preset("wholemilk", &milk));
    assert_true(ty_medium_preset_with("wholemilk", 1, &mixed));
    assert_memory_equal(mixed.sigma_s, milk.sigma_s, sizeof milk.sigma_s);
    assert_memory_equal(mixed.sigma_a, milk.sigma_a, sizeof milk.sigma_a);
    assert_true(ty_medium_preset_with("wholemilk", 1000, &mixed));
    for (int c = 0; c < 3; ++c) {
        assert_true(near((double)mixed.sigma_s[c], 0.001 * milk.sigma_s[c] + 0.999 * water.sigma_s[c], 1e-6));
        assert_true(near((double)mixed.sigma_a[c], 0.001 * milk.sigma_a[c] + 0.999 * water.sigma_a[c], 1e-6));
    }
    assert_true(ty_medium_preset_with("wholemilk", TY_DILUTION_MAX, &mixed));
    for (int c = 0; c < 3; ++c) {
        assert_true(near((double)mixed.sigma_s[c], (double)water.sigma_s[c], 1e-5));
        assert_true(near((double)mixed.sigma_a[c], (double)water.sigma_a[c], 1e-5));
    }
}

static void wrong_numbers_leave_the_def_alone(void** state) {
    (void)state;
    static const struct {
        const char* name;
        double number;
    } wrong[] = {{"fog", 0},         {"fog", -1},         {"fog", NAN},      {"haze", INFINITY}, {"wholemilk", 0.99},
                 {"wholemilk", NAN}, {"wholemilk", 1e13}, {"pure water", 1}, {"no such", 1}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        ty_medium_def def = ty_default_medium_def();
        def.sigma_a[2] = 7;
        assert_false(ty_medium_preset_with(wrong[i].name, wrong[i].number, &def));
        assert_float_equal(def.sigma_a[2], 7, 0);
    }
    assert_false(ty_medium_preset_with("fog", 1, NULL));
}

static void names_match_by_letters_and_digits(void** state) {
    (void)state;
    static const char* const same[] = {"Head & Shoulders Shampoo", "headshouldersshampoo", "HEAD-SHOULDERS_shampoo",
                                       " head shoulders shampoo! "};
    for (size_t i = 0; i < sizeof same / sizeof same[0]; ++i) {
        ty_medium_def def = ty_default_medium_def();
        def.g[1] = 0.5f;
        assert_true(ty_medium_preset(same[i], &def));
        assert_float_equal(def.sigma_s[0], 23.805f, 1e-4f);
        assert_float_equal(def.sigma_a[2], 203.65f, 1e-3f);
        assert_float_equal(def.g[1], 0, 0);
    }
    ty_medium_def skin = ty_default_medium_def();
    assert_true(ty_medium_preset("skin2", &skin));
    assert_float_equal(skin.sigma_s[0], 1090, 1e-3f);
}

static void unknown_names_leave_the_def_alone(void** state) {
    (void)state;
    static const char* const unknown[] = {"",  "milk", "skin",   "skin22",  "apple juices",
                                          "&", "fog",  "jerlov", "jerlov 1"};
    for (size_t i = 0; i < sizeof unknown / sizeof unknown[0]; ++i) {
        ty_medium_def def = ty_default_medium_def();
        def.sigma_s[0] = 7;
        assert_false(ty_medium_preset(unknown[i], &def));
        assert_float_equal(def.sigma_s[0], 7, 0);
    }
    ty_medium_def def = ty_default_medium_def();
    assert_false(ty_medium_preset(NULL, &def));
    assert_false(ty_medium_preset("apple", NULL));
    assert_null(ty_medium_preset_name(-1));
    assert_null(ty_medium_preset_name(ty_medium_preset_count()));
}

static void names_are_distinct(void** state) {
    (void)state;
    for (int32_t i = 0; i < ty_medium_preset_count(); ++i)
        assert_int_equal(ty_medium_preset_find(ty_medium_preset_name(i)), i);
    assert_int_equal(ty_medium_preset_find("no such"), -1);
    assert_int_equal(ty_medium_preset_find(NULL), -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_row_matches_the_measurements),
        cmocka_unit_test(waters_match_the_tables),
        cmocka_unit_test(a_twentieth_of_the_contrast_is_left_at_the_visibility),
        cmocka_unit_test(dilution_goes_from_the_medium_to_water),
        cmocka_unit_test(wrong_numbers_leave_the_def_alone),
        cmocka_unit_test(names_match_by_letters_and_digits),
        cmocka_unit_test(unknown_names_leave_the_def_alone),
        cmocka_unit_test(names_are_distinct),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
