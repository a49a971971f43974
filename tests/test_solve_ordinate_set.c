/* Sets of directions, and harmonics at them. */
#include "checks.h"
#include "solve/angular/harmonics.h"
#include "solve/angular/quadrature_table.h"
#include "solve/ordinates/ordinates.h"

#include "base/sh.k.h"

#define PI 3.141592653589793
enum { BANDS = 56, TERMS = BANDS * BANDS };

static void harmonics_are_those_of_the_kernels(void** state) {
    (void)state;
    uint64_t seed = 1;
    for (int i = 0; i < 100; ++i) {
        const ty_vec w = random_unit(&seed);
        const double direction[3] = {(double)w.x, (double)w.y, (double)w.z};
        float expected[TY_SH_TERMS_MAX];
        double y[TY_SH_TERMS_MAX];
        ty_sh_all(w, expected);
        ty_harmonics_at(direction, TY_SH_BANDS_MAX, y);
        for (int t = 0; t < TY_SH_TERMS_MAX; ++t) assert_close(y[t], (double)expected[t], 2e-6);
    }
}

/* The addition theorem: of each band the squares add up to (2 l + 1) / 4 pi, everywhere. */
static void harmonics_of_every_band_add_up(void** state) {
    (void)state;
    uint64_t seed = 2;
    for (int i = 0; i < 20; ++i) {
        const double z = uniform_in(&seed, -1, 1), turn = uniform_in(&seed, 0, 2 * PI), r = sqrt(1 - z * z);
        double y[TERMS];
        ty_harmonics_at((const double[3]){r * cos(turn), r * sin(turn), z}, BANDS, y);
        for (int l = 0; l < BANDS; ++l) {
            double sum = 0;
            for (int t = l * l; t < (l + 1) * (l + 1); ++t) sum += y[t] * y[t];
            assert_close(sum, (2 * l + 1) / (4 * PI), 1e-11);
        }
    }
}

static ty_angular_quadrature* make_set(void* context, int32_t count, int32_t* exact) {
    ty_angular_quadrature* set = malloc(sizeof *set);
    assert_int_equal(ty_angular_quadrature_create(context, count, set, exact), TY_OK);
    return set;
}

static void directions_are_mirrored(void** state) {
    for (int32_t count = 8; count <= 1024; count = count * 5 / 4) {
        int32_t exact = 0;
        ty_angular_quadrature* set = make_set(*state, count, &exact);
        const int32_t each = set->count / 8;
        assert_int_equal(set->first[8], set->count);
        for (int32_t d = 0; d < set->count; ++d) {
            const int32_t o = d / each;
            assert_int_equal(set->first[o], o * each);
            assert_true(set->weight[d] > 0);
            double square = 0;
            for (int a = 0; a < 3; ++a) {
                const double component = (double)set->direction[a][d];
                square += component * component;
                assert_true(fabs(component) > 0.01);
                assert_int_equal(component < 0, o >> a & 1);
                assert_close(fabs(component), (double)set->direction[a][d % each], 0);
            }
            assert_close(square, 1, 1e-6);
        }
        free(set);
    }
}

/* Every set of the table: sums of harmonics up to the order it claims, and of products of two of them that together
 * reach no higher. */
static void sums_are_exact(void** state) {
    int32_t before = 0;
    for (int32_t count = 8; count <= 1024; ++count) {
        int32_t exact = 0;
        ty_angular_quadrature* set = make_set(*state, count, &exact);
        if (set->count == before) {
            free(set);
            continue;
        }
        assert_true(set->count > before && exact < BANDS);
        before = set->count;
        const int32_t terms = (exact + 1) * (exact + 1), half = exact / 2 + 1, kept = half * half;
        double* sum = calloc((size_t)terms, sizeof *sum);
        double* product = calloc((size_t)kept * (size_t)kept, sizeof *product);
        for (int32_t d = 0; d < set->count; ++d) {
            double y[TERMS];
            ty_harmonics_at((const double[3]){(double)set->direction[0][d], (double)set->direction[1][d],
                                              (double)set->direction[2][d]},
                            exact + 1, y);
            for (int32_t t = 0; t < terms; ++t) sum[t] += (double)set->weight[d] * y[t];
            for (int32_t i = 0; i < kept * kept; ++i) product[i] += (double)set->weight[d] * y[i / kept] * y[i % kept];
        }
        for (int32_t t = 0; t < terms; ++t) assert_close(sum[t], t == 0 ? sqrt(4 * PI) : 0, 3e-6);
        for (int32_t i = 0; i < kept * kept; ++i) assert_close(product[i], i / kept == i % kept, 3e-6);
        free(product);
        free(sum);
        free(set);
    }
    assert_true(before > 400);
}

/* As much of even light as should flows through a plane across each axis. */
static void light_flows_through_planes(void** state) {
    for (int32_t count = 24; count <= 1024; count = count * 5 / 4) {
        ty_angular_quadrature* set = make_set(*state, count, NULL);
        double flow[3] = {0};
        for (int32_t d = 0; d < set->first[1]; ++d)
            for (int a = 0; a < 3; ++a) flow[a] += 4 * (double)(set->weight[d] * set->direction[a][d]);
        for (int a = 0; a < 3; ++a) assert_close(flow[a], PI, 3e-6);
        free(set);
    }
}

static void sets_are_about_as_large_as_asked_for(void** state) {
    static const int32_t counts[][3] = {{24, 24, 3}, {48, 48, 7}, {96, 96, 11}, {168, 168, 15}, {224, 224, 19}};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        int32_t exact = 0;
        ty_angular_quadrature* set = make_set(*state, counts[i][0], &exact);
        assert_int_equal(set->count, counts[i][1]);
        assert_int_equal(exact, counts[i][2]);
        free(set);
    }
    ty_angular_quadrature* set = malloc(sizeof *set);
    assert_int_equal(ty_angular_quadrature_create(*state, 7, set, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "7 ordinates");
    assert_int_equal(ty_angular_quadrature_create(*state, 1025, set, NULL), TY_ERROR_ARGUMENT);
    free(set);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(harmonics_are_those_of_the_kernels),
        cmocka_unit_test(harmonics_of_every_band_add_up),
        cmocka_unit_test_setup_teardown(directions_are_mirrored, start_context, stop_context),
        cmocka_unit_test_setup_teardown(sums_are_exact, start_context, stop_context),
        cmocka_unit_test_setup_teardown(light_flows_through_planes, start_context, stop_context),
        cmocka_unit_test_setup_teardown(sets_are_about_as_large_as_asked_for, start_context, stop_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
