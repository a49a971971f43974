/* Principal ordinates' fluence against path tracing's: Fig. 12, the unit cube in parallel light. */
#include "truth_cube.h"

static const double anisotropies[] = {0, 0.7, 0.96};

static error measure(const ty_scene* scene, bool sharp, const truth* expected) {
    ty_context* context = ty_scene_context(scene);
    double* fluence = new_numbers(3 * CELLS);
    ty_pop* light = NULL;
    ty_pop_stats stats;
    ty_pop_def def = ty_default_pop_def();
    def.resolution = COARSE;
    def.sharp = sharp;
    must(context, ty_pop_solve(scene, &def, &light, &stats));
    must(context, ty_pop_fluence(light, low, high, coarse, fluence, NULL));
    assert_true(stats.converged);
    const error result = error_of(fluence, expected);
    ty_pop_destroy(light);
    free(fluence);
    return result;
}

static void test_cube(void** state) {
    static truth expected;
    for (int i = 0; i < 3; ++i) {
        ty_scene* scene = cube_in_light(*state, anisotropies[i]);
        trace(scene, anisotropies[i], &expected);
        for (int sharp = 0; sharp <= 1; ++sharp) {
            const error pop = measure(scene, sharp != 0, &expected);
            printf("g %.2f, %s: %.4f / %.4f (mean ratio / relative RMSE; noise %.4f)\n", anisotropies[i],
                   sharp != 0 ? "fine cells" : "an ordinate's", pop.mean_ratio, pop.rmse, expected.noise);
            assert_true(fabs(pop.mean_ratio - 1) <= 0.07);
            assert_true(pop.rmse <= 0.2);
        }
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cube)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
