/* Measured media: the table against the published numbers, and how names match. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <tyndall/scene.h>

static void test_every_row_matches_the_measurements(void** state) {
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
    assert_int_equal(ty_medium_preset_count(), row);
}

static void test_names_match_by_letters_and_digits(void** state) {
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

static void test_unknown_names_leave_the_def_alone(void** state) {
    (void)state;
    static const char* const unknown[] = {"", "milk", "skin", "skin22", "apple juices", "&"};
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

static void test_names_are_distinct(void** state) {
    (void)state;
    for (int32_t i = 0; i < ty_medium_preset_count(); ++i) {
        ty_medium_def by_name = ty_default_medium_def(), other = ty_default_medium_def();
        assert_true(ty_medium_preset(ty_medium_preset_name(i), &by_name));
        for (int32_t j = 0; j < i; ++j) {
            assert_true(ty_medium_preset(ty_medium_preset_name(j), &other));
            assert_memory_not_equal(by_name.sigma_a, other.sigma_a, sizeof other.sigma_a);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_row_matches_the_measurements),
        cmocka_unit_test(test_names_match_by_letters_and_digits),
        cmocka_unit_test(test_unknown_names_leave_the_def_alone),
        cmocka_unit_test(test_names_are_distinct),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
