/* Sets of directions and sweeps. */
#include "checks.h"
#include "solve/harmonics.h"
#include "solve/sweep.h"

#include "base/sh.k.h"

#define PI 3.141592653589793

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

static void a_set_is_mirrored_and_complete(void** state) {
    ty_ordinate_set* set = malloc(sizeof *set);
    const int32_t counts[] = {8, 24, 48, 96, 168, 400, 1024};
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; ++c) {
        assert_int_equal(ty_ordinate_set_make(*state, counts[c], set, NULL), TY_OK);
        const int32_t each = set->count / 8;
        assert_int_equal(set->first[8], set->count);
        double sum = 0;
        for (int32_t d = 0; d < set->count; ++d) {
            const int32_t o = d / each;
            assert_int_equal(set->first[o], o * each);
            sum += (double)set->weight[d];
            double square = 0;
            for (int a = 0; a < 3; ++a) {
                const double component = (double)set->direction[a][d];
                square += component * component;
                assert_true(fabs(component) > 1e-4);
                assert_int_equal(component < 0, o >> a & 1);
                assert_close(fabs(component), (double)set->direction[a][d % each], 0);
            }
            assert_close(square, 1, 1e-6);
        }
        assert_close(sum, 4 * PI, 1e-4);
    }
    free(set);
}

/* A box of 5 x 4 x 6 cells with random extinction, lit by itself. */
typedef struct lit_box {
    int32_t size[3];
    double cell[3];
    float extinction[120], emission[120 * 9], moments[120 * 9];
} lit_box;

static lit_box* make_box(void) {
    lit_box* box = calloc(1, sizeof *box);
    *box = (lit_box){.size = {5, 4, 6}, .cell = {0.2, 0.3, 0.1}};
    uint64_t seed = 7;
    for (int i = 0; i < 120; ++i) {
        box->extinction[i] = (float)exp(uniform_in(&seed, log(1e-3), log(1e5)));
        if (i % 7 == 0) box->extinction[i] = 0;
        box->emission[i * 9] = i % 5 == 0 ? (float)uniform(&seed) : 0;
    }
    return box;
}

static void what_is_emitted_is_absorbed_or_leaves(void** state) {
    ty_ordinate_set* set = malloc(sizeof *set);
    assert_int_equal(ty_ordinate_set_make(*state, 96, set, NULL), TY_OK);
    lit_box* box = make_box();
    ty_sweep* sweep = NULL;
    assert_int_equal(ty_sweep_create(*state, box->size, box->cell, set, 3, box->extinction, &sweep), TY_OK);
    double leaving = 0, fixed = 0, emitted = 0, absorbed = 0;
    assert_int_equal(ty_sweep_run(sweep, box->emission, box->moments, &leaving, &fixed), TY_OK);
    const double volume = box->cell[0] * box->cell[1] * box->cell[2], fluence = sqrt(4 * PI);
    for (int i = 0; i < 120; ++i) {
        emitted += volume * fluence * (double)box->emission[i * 9];
        absorbed += volume * fluence * (double)box->extinction[i] * (double)box->moments[i * 9];
        assert_true(box->moments[i * 9] >= 0);
    }
    assert_true(fixed > 0);
    assert_true(leaving > 0.01 * emitted);
    assert_close((absorbed + leaving) / emitted, 1, 3e-6);
    ty_sweep_destroy(sweep);
    free(box);
    free(set);
}

/* The same light from all around fills an empty box, and leaves it. */
static void light_comes_in_through_faces(void** state) {
    ty_ordinate_set* set = malloc(sizeof *set);
    float radiance[TY_ORDINATES_MAX];
    assert_int_equal(ty_ordinate_set_make(*state, 48, set, NULL), TY_OK);
    for (int32_t d = 0; d < set->count; ++d) radiance[d] = 2;
    lit_box* box = make_box();
    memset(box->extinction, 0, sizeof box->extinction);
    memset(box->emission, 0, sizeof box->emission);
    ty_sweep* sweep = NULL;
    double leaving = 0;
    assert_int_equal(ty_sweep_create(*state, box->size, box->cell, set, 1, box->extinction, &sweep), TY_OK);
    ty_sweep_let_in(sweep, radiance);
    assert_int_equal(ty_sweep_run(sweep, box->emission, box->moments, &leaving, NULL), TY_OK);
    for (int i = 0; i < 120; ++i) assert_close(sqrt(4 * PI) * (double)box->moments[i], 8 * PI, 1e-4);
    double through = 0; /* W: of all faces, half of the directions */
    for (int32_t d = 0; d < set->count; ++d)
        for (int a = 0; a < 3; ++a) {
            const double area =
                box->cell[(a + 1) % 3] * box->size[(a + 1) % 3] * box->cell[(a + 2) % 3] * box->size[(a + 2) % 3];
            through += 2 * (double)set->weight[d] * fabs((double)set->direction[a][d]) * area;
        }
    assert_close(leaving / through, 1, 1e-5);
    ty_sweep_let_in(sweep, NULL);
    assert_int_equal(ty_sweep_run(sweep, box->emission, box->moments, &leaving, NULL), TY_OK);
    assert_true(leaving == 0);
    ty_sweep_destroy(sweep);
    free(box);
    free(set);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(harmonics_are_those_of_the_kernels),
        cmocka_unit_test_setup_teardown(a_set_is_mirrored_and_complete, start_context, stop_context),
        cmocka_unit_test_setup_teardown(what_is_emitted_is_absorbed_or_leaves, start_context, stop_context),
        cmocka_unit_test_setup_teardown(light_comes_in_through_faces, start_context, stop_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
