/* Distances filled from the known ones around them. */
#include "screen_maker.h"

#include "base/kernel.h"

static int64_t fill(ty_context* context, int32_t width, int32_t height, float* distance) {
    int64_t filled = -1;
    assert_int_equal(ty_screen_fill_distance(context, width, height, distance, &filled), TY_OK);
    return filled;
}

static bool known(float distance) {
    return distance > 0 && distance < TY_FLOAT_MAX;
}

static float hole(int32_t i) {
    static const uint32_t bits[] = {0, 0x80000000u, 0xbf800000u, 0x7f800000u, 0xff800000u, 0x7fc00000u};
    return ty_float_from_bits(bits[i % 6]);
}

/* Of all sizes and shares of holes: what is known stays, what is not comes to lie between the least and the most. */
static void holes_are_filled(void** state) {
    uint64_t random = 1;
    for (int trial = 0; trial < 300; ++trial) {
        const int32_t width = 1 + (int32_t)(uniform(&random) * 40), height = 1 + (int32_t)(uniform(&random) * 40);
        picture p = make_picture(width, height, 1), before = make_picture(width, height, 1);
        const double share = pow(uniform(&random), trial % 2 == 0 ? 1 : 0.1);
        int64_t holes = 0;
        double low = INFINITY, high = 0;
        for (int32_t i = 0; i < pixel_count(&p); ++i) {
            const bool missing = uniform(&random) < share;
            p.distance[i] = missing ? hole(i) : (float)uniform_in(&random, 2, 50);
            before.distance[i] = p.distance[i];
            holes += missing;
            if (missing) continue;
            low = fmin(low, (double)p.distance[i]);
            high = fmax(high, (double)p.distance[i]);
        }
        if (holes == pixel_count(&p)) holes = 0; /* there is nothing to fill them from */
        assert_int_equal(fill(*state, width, height, p.distance), holes);
        for (int32_t i = 0; i < pixel_count(&p); ++i) {
            if (known(before.distance[i]) || high <= 0) {
                assert_memory_equal(&p.distance[i], &before.distance[i], sizeof(float));
            } else if (!((double)p.distance[i] >= low * 0.99999 && (double)p.distance[i] <= high * 1.00001)) {
                fail_msg("trial %d: %g is outside %g..%g", trial, (double)p.distance[i], low, high);
            }
        }
        free_picture(&p);
        free_picture(&before);
    }
}

static void a_constant_stays_one(void** state) {
    static const double constants[] = {1e-30, 0.1, 3.3, 1e14};
    for (int k = 0; k < 4; ++k) {
        picture p = make_picture(101, 53, constants[k]);
        const double constant = (double)p.distance[0];
        for (int32_t i = 0; i < pixel_count(&p); ++i)
            if (i % 7 != 3 || i / 101 < 20) p.distance[i] = hole(i);
        fill(*state, 101, 53, p.distance);
        for (int32_t i = 0; i < pixel_count(&p); ++i) assert_close((double)p.distance[i], constant, 1e-6 * constant);
        free_picture(&p);
    }
}

/* The nearest of two known halves decides. */
static void holes_follow_what_is_near(void** state) {
    picture p = make_picture(64, 16, 0);
    for (int32_t i = 0; i < pixel_count(&p); ++i) {
        if (i % 64 < 24) p.distance[i] = 2;
        if (i % 64 >= 40) p.distance[i] = 10;
    }
    assert_int_equal(fill(*state, 64, 16, p.distance), 16 * 16);
    for (int32_t y = 0; y < 16; ++y) {
        const float* row = p.distance + 64 * y;
        assert_true(row[24] < 3.5f && row[39] > 8.5f);
        for (int32_t x = 24; x < 39; ++x) assert_true(row[x] <= row[x + 1] + 1e-4f);
    }
    free_picture(&p);
}

/* Distances that count as known to ty_screen_apply count here: huge distances, and the tiniest. */
static void extremes_are_known(void** state) {
    float distance[9] = {0, 3e38f, 0, 1e-45f, 0, 1e16f, 0, 1e-38f, 0}, before[9];
    memcpy(before, distance, sizeof before);
    assert_int_equal(fill(*state, 3, 3, distance), 5);
    for (int i = 0; i < 9; ++i) {
        assert_true(known(distance[i]));
        if (i % 2 == 1) assert_memory_equal(&distance[i], &before[i], sizeof(float));
    }
    float tiny[6] = {0, 1e-45f, 0, 0, 1e-45f, 0};
    assert_int_equal(fill(*state, 6, 1, tiny), 4);
    for (int i = 0; i < 6; ++i) assert_true(known(tiny[i]));
}

static void bad_arguments_are_refused(void** state) {
    float distance[4] = {1, 0, 0, 0};
    int64_t filled = 0;
    assert_int_equal(ty_screen_fill_distance(NULL, 2, 2, distance, &filled), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_screen_fill_distance(*state, 0, 2, distance, &filled), TY_ERROR_ARGUMENT);
    assert_error(*state, "0 x 2");
    assert_int_equal(ty_screen_fill_distance(*state, 2, 65537, distance, &filled), TY_ERROR_ARGUMENT);
    assert_error(*state, "2 x 65537");
    assert_int_equal(ty_screen_fill_distance(*state, 2, 2, NULL, &filled), TY_ERROR_ARGUMENT);
    assert_error(*state, "NULL");
    assert_int_equal(ty_screen_fill_distance(*state, 2, 2, distance, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "NULL");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(holes_are_filled),          cmocka_unit_test(a_constant_stays_one),
        cmocka_unit_test(holes_follow_what_is_near), cmocka_unit_test(extremes_are_known),
        cmocka_unit_test(bad_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
