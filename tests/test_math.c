/* Numbers: elementary functions against libm, halves, frames, affine maps. */
#include "checks.h"

#include "base/half.h"

#include <float.h>

static const double two_pi = 6.283185307179586477;

/* The distance between value and exact in units of the last place of a float near exact. */
static double ulps(float value, double exact) {
    int exponent;
    frexp(exact, &exponent);
    return fabs((double)value - exact) / ldexp(1, exponent - 24);
}

static void exponential_is_within_two_ulps(void** state) {
    (void)state;
    double worst = 0;
    const int steps = 2000000;
    for (int i = 0; i <= steps; ++i) {
        const float x = (float)(-87 + 175.0 * i / steps);
        worst = fmax(worst, ulps(ty_expf(x), exp((double)x)));
    }
    for (float x = 1e-30f; x < 1; x *= 1.001f) {
        worst = fmax(worst, ulps(ty_expf(x), exp((double)x)));
        worst = fmax(worst, ulps(ty_expf(-x), exp(-(double)x)));
    }
    if (worst > 2) fail_msg("%g ulp", worst);
    assert_true(ty_expf(0) == 1);
}

static void exponential_saturates(void** state) {
    (void)state;
    assert_true(ty_expf(-87.001f) == 0);
    assert_true(ty_expf(-INFINITY) == 0);
    assert_true(ty_expf(-FLT_MAX) == 0);
    assert_true(ty_expf(-87.0f) > 0);
    assert_true(ty_expf(1000) == ty_expf(88));
    assert_true(ty_expf(INFINITY) == ty_expf(88));
}

static void logarithm_is_within_two_ulps(void** state) {
    (void)state;
    double worst = 0;
    for (uint32_t bits = 0x00800000u; bits < 0x7f800000u; bits += 977) {
        const float x = ty_float_from_bits(bits);
        worst = fmax(worst, ulps(ty_logf(x), log((double)x)));
    }
    /* Every fifth float from 1/2 to 2: where digits may cancel. */
    for (uint32_t bits = 0x3f000000u; bits < 0x40000000u; bits += 5) {
        const float x = ty_float_from_bits(bits);
        if (x != 1) worst = fmax(worst, ulps(ty_logf(x), log((double)x)));
    }
    if (worst > 2) fail_msg("%g ulp", worst);
    assert_true(ty_logf(1) == 0);
}

static void sine_and_cosine_of_a_turn(void** state) {
    (void)state;
    double worst = 0;
    float sine, cosine;
    for (int i = 0; i <= 1 << 21; ++i) {
        const float u = (float)i * 0x1p-21f;
        ty_sincos_2pi(u, &sine, &cosine);
        worst = fmax(worst, fabs((double)sine - sin(two_pi * (double)u)));
        worst = fmax(worst, fabs((double)cosine - cos(two_pi * (double)u)));
    }
    if (worst > 1.2e-7) fail_msg("error %g", worst);
    ty_sincos_2pi(0x1.fffffep-1f, &sine, &cosine);
    assert_close(sine, 0, 4e-7);
    assert_close(cosine, 1, 1e-7);
}

/* A half's value by its definition. */
static double half_value(uint16_t half) {
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    const double sign = (half & 0x8000) != 0 ? -1 : 1;
    return sign * (exponent == 0 ? ldexp(mantissa, -24) : ldexp(1024 + mantissa, exponent - 25));
}

static void halves_become_floats_exactly(void** state) {
    (void)state;
    for (uint32_t h = 0; h < 65536; ++h) {
        const float value = ty_half_to_float((uint16_t)h);
        const bool special = (h & 0x7c00u) == 0x7c00u;
        if (special && (h & 1023u) != 0) {
            assert_true(isnan(value));
            assert_true(isnan(ty_half_to_float(ty_float_to_half(value))));
            continue;
        }
        if (special)
            assert_true(isinf(value) && (value < 0) == (h >> 15));
        else
            assert_true((double)value == half_value((uint16_t)h) && !!signbit(value) == (h >> 15));
        assert_int_equal(ty_float_to_half(value), h);
    }
}

/* Between each two neighbouring halves: the middle goes to the even one, the rest to the nearer. */
static void floats_round_to_the_nearest_half(void** state) {
    (void)state;
    for (uint32_t h = 0; h < 0x7c00u; ++h) {
        const double low = half_value((uint16_t)h), high = h == 0x7bffu ? 65536 : half_value((uint16_t)(h + 1));
        const float middle = (float)((low + high) / 2);
        const uint32_t even = h + (h & 1u);
        assert_int_equal(ty_float_to_half(middle), even);
        assert_int_equal(ty_float_to_half(-middle), even | 0x8000u);
        assert_int_equal(ty_float_to_half(nextafterf(middle, 0)), h);
        assert_int_equal(ty_float_to_half(nextafterf(middle, INFINITY)), h + 1);
    }
    assert_int_equal(ty_float_to_half(FLT_MAX), 0x7c00);
    assert_int_equal(ty_float_to_half(-INFINITY), 0xfc00);
    assert_int_equal(ty_float_to_half(FLT_TRUE_MIN), 0);
    assert_int_equal(ty_float_to_half(-0.0f), 0x8000);
}

static void assert_frame(ty_vec n) {
    ty_vec s, t;
    ty_onb(n, &s, &t);
    assert_close(ty_dot(s, s), 1, 1e-6);
    assert_close(ty_dot(t, t), 1, 1e-6);
    assert_close(ty_dot(s, t), 0, 1e-6);
    assert_close(ty_dot(s, n), 0, 1e-6);
    assert_vec_close(ty_cross(s, t), n, 1e-6);
}

static void frames_are_right_handed(void** state) {
    (void)state;
    uint64_t random = 1;
    assert_frame(ty_vec_make(0, 0, 1));
    assert_frame(ty_vec_make(0, 0, -1));
    assert_frame(ty_vec_make(1, 0, -0.0f));
    assert_frame(ty_normalize(ty_vec_make(1e-4f, -1e-4f, -1)));
    for (int i = 0; i < 10000; ++i) assert_frame(random_unit(&random));
}

static void directions_about_an_axis(void** state) {
    (void)state;
    uint64_t random = 2;
    for (int i = 0; i < 10000; ++i) {
        const ty_vec axis = random_unit(&random);
        const float mu = (float)uniform_in(&random, -1, 1), turn = (float)uniform(&random);
        const ty_vec a = ty_direction_about(axis, mu, turn);
        assert_close(ty_dot(a, a), 1, 2e-6);
        assert_close(ty_dot(a, axis), mu, 2e-6);
        /* A quarter turn further on is a quarter turn counter-clockwise about the axis. */
        const ty_vec b = ty_direction_about(axis, mu, turn < 0.75f ? turn + 0.25f : turn - 0.75f);
        const ty_vec off = ty_mad(a, axis, -mu);
        assert_vec_close(ty_mad(b, axis, -mu), ty_cross(axis, off), 4e-6);
    }
}

static void assert_maps(const ty_affine* map, double x, double y, double z, double ex, double ey, double ez) {
    double point[3] = {x, y, z};
    ty_affine_point(map, point, point);
    assert_close(point[0], ex, 1e-12);
    assert_close(point[1], ey, 1e-12);
    assert_close(point[2], ez, 1e-12);
}

static void rotations_are_counter_clockwise(void** state) {
    (void)state;
    const double none[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const double about_x[3] = {90, 0, 0}, about_y[3] = {0, 90, 0}, about_z[3] = {0, 0, 90};
    const ty_affine x = ty_affine_compose(none, about_x, one);
    const ty_affine y = ty_affine_compose(none, about_y, one);
    const ty_affine z = ty_affine_compose(none, about_z, one);
    assert_maps(&x, 1, 2, 3, 1, -3, 2);
    assert_maps(&y, 1, 2, 3, 3, 2, -1);
    assert_maps(&z, 1, 2, 3, -2, 1, 3);
}

static void maps_compose_in_the_documented_order(void** state) {
    (void)state;
    const double none[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const double move[3] = {3, -4, 5}, scale[3] = {2, -3, 0.5}, turn[3] = {20, -70, 130};
    const double turns[3][3] = {{20, 0, 0}, {0, -70, 0}, {0, 0, 130}};
    ty_affine expected = ty_affine_compose(none, none, scale);
    for (int axis = 0; axis < 3; ++axis) {
        const ty_affine rotation = ty_affine_compose(none, turns[axis], one);
        expected = ty_affine_multiply(&rotation, &expected);
    }
    const ty_affine translation = ty_affine_compose(move, none, one);
    expected = ty_affine_multiply(&translation, &expected);
    const ty_affine whole = ty_affine_compose(move, turn, scale);
    for (int i = 0; i < 12; ++i) assert_close(whole.m[i], expected.m[i], 1e-12);
}

static void inverses_undo(void** state) {
    (void)state;
    uint64_t random = 3;
    for (int i = 0; i < 1000; ++i) {
        ty_affine map, inverse;
        for (int j = 0; j < 12; ++j) map.m[j] = uniform_in(&random, -10, 10);
        if (!ty_affine_invert(&map, &inverse)) continue;
        const ty_affine both[2] = {ty_affine_multiply(&map, &inverse), ty_affine_multiply(&inverse, &map)};
        const ty_affine identity = ty_affine_identity();
        for (int j = 0; j < 24; ++j) assert_close(both[j / 12].m[j % 12], identity.m[j % 12], 1e-6);
    }
    const double none[3] = {0, 0, 0}, tiny[3] = {1e-30, 2e-30, 3e-30};
    const ty_affine small = ty_affine_compose(none, none, tiny);
    ty_affine inverse;
    assert_true(ty_affine_invert(&small, &inverse));
    assert_close(inverse.m[5] * 2e-30, 1, 1e-12);
}

static void singular_maps_have_no_inverse(void** state) {
    (void)state;
    const ty_affine before = {{7, 0, 0, 0, 0, 7, 0, 0, 0, 0, 7, 0}};
    const ty_affine flat = {{1, 2, 3, 0, 2, 4, 6, 0, 0, 0, 1, 0}};
    ty_affine infinite = ty_affine_identity(), inverse = before, nowhere = {{0}};
    infinite.m[0] = NAN;
    assert_false(ty_affine_invert(&flat, &inverse));
    assert_false(ty_affine_invert(&nowhere, &inverse));
    assert_false(ty_affine_invert(&infinite, &inverse));
    infinite.m[0] = INFINITY;
    assert_false(ty_affine_invert(&infinite, &inverse));
    assert_memory_equal(&inverse, &before, sizeof before);
}

static void single_precision_maps_agree(void** state) {
    (void)state;
    const double move[3] = {3, -4, 5}, scale[3] = {2, -3, 0.5}, turn[3] = {20, -70, 130};
    const ty_affine map = ty_affine_compose(move, turn, scale);
    float m[12];
    for (int i = 0; i < 12; ++i) m[i] = (float)map.m[i];
    double point[3] = {1.5, -2.5, 0.25}, image[3], zero[3] = {0, 0, 0};
    ty_affine_point(&map, point, image);
    ty_affine_point(&map, zero, zero);
    const ty_vec p = ty_vec_make(1.5f, -2.5f, 0.25f), offset = ty_vec_load(m);
    assert_true(offset.x == m[0] && offset.y == m[1] && offset.z == m[2]);
    assert_vec_close(ty_map_point(m, p), ty_vec_make((float)image[0], (float)image[1], (float)image[2]), 1e-5);
    assert_vec_close(ty_map_direction(m, p),
                     ty_vec_make((float)(image[0] - zero[0]), (float)(image[1] - zero[1]), (float)(image[2] - zero[2])),
                     1e-5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exponential_is_within_two_ulps),
        cmocka_unit_test(exponential_saturates),
        cmocka_unit_test(logarithm_is_within_two_ulps),
        cmocka_unit_test(sine_and_cosine_of_a_turn),
        cmocka_unit_test(halves_become_floats_exactly),
        cmocka_unit_test(floats_round_to_the_nearest_half),
        cmocka_unit_test(frames_are_right_handed),
        cmocka_unit_test(directions_about_an_axis),
        cmocka_unit_test(rotations_are_counter_clockwise),
        cmocka_unit_test(maps_compose_in_the_documented_order),
        cmocka_unit_test(inverses_undo),
        cmocka_unit_test(singular_maps_have_no_inverse),
        cmocka_unit_test(single_precision_maps_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
