/* Flux-limited diffusion's fluence against path tracing's: the unit cube in parallel light. */
#include "truth_cube.h"

static const double anisotropies[] = {0, 0.5, 0.7, 0.96};

static error measure(const ty_scene* scene, const ty_fld_def* def, const truth* expected) {
    ty_context* context = ty_scene_context(scene);
    double* fluence = new_numbers(3 * CELLS);
    double* flux = new_numbers(9 * CELLS);
    ty_fld* light = NULL;
    ty_fld_stats stats;
    must(context, ty_fld_solve(scene, def, &light, &stats));
    must(context, ty_fld_fluence(light, low, high, coarse, fluence, NULL, flux));
    assert_true(stats.converged);
    for (int i = 0; i < CELLS; ++i) {
        const double length =
            sqrt(flux[9 * i] * flux[9 * i] + flux[9 * i + 1] * flux[9 * i + 1] + flux[9 * i + 2] * flux[9 * i + 2]);
        if (!(length <= fluence[3 * i] * (1 + 1e-5)))
            fail_msg("cell %d: flux %g, fluence %g", i, length, fluence[3 * i]);
    }
    if (!(fabs(stats.absorbed[0] + stats.leaving[0] - stats.emitted[0]) <= 1e-3 * stats.emitted[0]))
        fail_msg("emitted %g, absorbed %g, leaving %g", stats.emitted[0], stats.absorbed[0], stats.leaving[0]);
    const error result = error_of(fluence, expected);
    ty_fld_destroy(light);
    free(fluence);
    free(flux);
    return result;
}

/* Whatever the resolution, and half as fine for diffusion, the answer is the same. */
static void test_cube(void** state) {
    static const int32_t resolutions[] = {16, 32, 64};
    static truth expected;
    for (int i = 0; i < 4; ++i) {
        if (anisotropies[i] == 0.5 && !in_full()) continue;
        ty_scene* scene = cube_in_light(*state, anisotropies[i]);
        double first = 0;
        trace(scene, anisotropies[i], &expected);
        for (int r = 0; r < (in_full() ? 3 : 2); ++r)
            for (int ratio = 1; ratio <= 2; ++ratio) {
                ty_fld_def def = ty_default_fld_def();
                def.resolution = resolutions[r];
                def.ratio = ratio;
                const error fld = measure(scene, &def, &expected);
                printf("g %.2f, %2d^3 / %d: %.4f / %.4f (mean ratio / relative RMSE; noise %.4f)\n", anisotropies[i],
                       resolutions[r], ratio, fld.mean_ratio, fld.rmse, expected.noise);
                assert_true(fabs(fld.mean_ratio - 1) <= 0.07);
                assert_true(fld.rmse <= 0.2);
                if (r == 0 && ratio == 1) first = fld.mean_ratio;
                assert_true(fabs(fld.mean_ratio - first) <= 0.03);
            }
        ty_scene_destroy(scene);
    }
}

/* What the paper has: a flux that may be as large as the fluence, and none of it on the faces. */
static void test_published(void** state) {
    static truth expected;
    ty_scene* scene = cube_in_light(*state, 0);
    trace(scene, 0, &expected);
    ty_fld_def def = ty_default_fld_def();
    def.resolution = 32;
    def.ratio = 1;
    const error ours = measure(scene, &def, &expected);
    def.max_flux_fraction = 1;
    const error unlimited = measure(scene, &def, &expected);
    def.boundary = TY_FLD_BOUNDARY_DIRICHLET;
    const error paper = measure(scene, &def, &expected);
    printf("g 0, 32^3: ours %.4f / %.4f, flux fraction 1 %.4f / %.4f, and no fluence on the faces %.4f / %.4f\n",
           ours.mean_ratio, ours.rmse, unlimited.mean_ratio, unlimited.rmse, paper.mean_ratio, paper.rmse);
    assert_true(ours.rmse < unlimited.rmse && unlimited.rmse < paper.rmse);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cube), cmocka_unit_test(test_published)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
