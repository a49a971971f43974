/* Principal ordinates' fluence against path tracing's: Fig. 12, the unit cube in parallel light. */
#include "truth_cube.h"

/* Measured with an ordinate's cells and with fine ones: mean ratio and relative RMSE. The bounds are 0.015 about the
 * ratio and 0.012 above the RMSE, which is as much as quick runs' truth is noisy (0.024 at g = 0.7, which is taken off
 * in the square). A prototype with one beam and one diffusion solve has 0.99 / .08, 1.06 / .18 and 1.05 / .14. */
typedef struct cube_case {
    double g;
    struct {
        double ratio, rmse;
    } measured[2];
} cube_case;

static const cube_case cases[] = {{0, {{1.014, 0.092}, {1.014, 0.092}}},
                                  {0.7, {{1.054, 0.177}, {1.008, 0.144}}},
                                  {0.96, {{1.042, 0.133}, {1.024, 0.134}}}};
static const double ratio_margin = 0.015, rmse_margin = 0.012;

static error measure(const ty_scene* scene, bool fine_lights, const truth* expected) {
    ty_context* context = ty_scene_context(scene);
    double* fluence = new_numbers(3 * CELLS);
    ty_pop* light = NULL;
    ty_pop_stats stats = ty_default_pop_stats();
    ty_pop_def def = ty_default_pop_def();
    def.resolution = COARSE;
    def.fine_lights = fine_lights;
    must(context, ty_pop_solve(scene, &def, &light, &stats));
    must(context, ty_pop_fluence(light, low, high, coarse, fluence, NULL));
    assert_true(stats.converged);
    const error result = error_of(fluence, expected);
    ty_pop_destroy(light);
    free(fluence);
    return result;
}

static void the_cube_is_as_bright_as_measured(void** state) {
    static truth expected;
    for (int i = 0; i < 3; ++i) {
        const double g = cases[i].g;
        ty_scene* scene = cube_in_light(*state, g);
        trace(scene, g, &expected);
        for (int fine_lights = 0; fine_lights <= 1; ++fine_lights) {
            const error pop = measure(scene, fine_lights != 0, &expected);
            printf("g %.2f, %s: %.4f / %.4f (mean ratio / relative RMSE; noise %.4f)\n", g,
                   fine_lights != 0 ? "fine cells" : "an ordinate's", pop.mean_ratio, pop.rmse, expected.noise);
            assert_true(fabs(pop.mean_ratio - cases[i].measured[fine_lights].ratio) <= ratio_margin);
            assert_true(pop.rmse <= cases[i].measured[fine_lights].rmse + rmse_margin);
        }
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_cube_is_as_bright_as_measured)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
