/* Flux-limited diffusion's fluence against path tracing's: the unit cube in parallel light. */
#include "truth_cube.h"

/* Mean ratio and relative RMSE, measured with 16^3, 32^3 and 64^3 cells and diffusion on all of them; on half of them
 * it is what the coarser resolution is, but for 8^3, which have a row of their own. A prototype of one beam and one
 * solve has 0.99 / .08, 1.04 / .16, 1.06 / .18 and 1.05 / .14 at 16^3. The bounds are 0.015 about the ratio and 0.012
 * above the RMSE: g = 0.96 is against walks from the light, 0.01 above the paths of docs/method/fld.md. */
enum { SIZES = 3 };

typedef struct cube_case {
    double g;
    struct {
        double ratio, rmse;
    } coarsest, measured[SIZES];
} cube_case;

static const cube_case cases[] = {
    {0, {0.988, 0.143}, {{0.987, 0.092}, {1.003, 0.089}, {1.017, 0.087}}},
    {0.5, {1.007, 0.184}, {{1.019, 0.163}, {1.032, 0.162}, {1.041, 0.163}}},
    {0.7, {1.022, 0.187}, {{1.033, 0.177}, {1.043, 0.177}, {1.049, 0.178}}},
    {0.96, {1.037, 0.134}, {{1.039, 0.133}, {1.040, 0.133}, {1.041, 0.133}}},
};
static const double ratio_margin = 0.015, rmse_margin = 0.012;

static error measure(const ty_scene* scene, const ty_fld_def* def, const truth* expected) {
    ty_context* context = ty_scene_context(scene);
    double* fluence = new_numbers(3 * CELLS);
    double* flux = new_numbers(9 * CELLS);
    ty_fld* light = NULL;
    ty_fld_stats stats = ty_default_fld_stats();
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

/* The answer hardly depends on the resolution, nor on whether diffusion is half as fine. */
static void the_cube_is_as_bright_as_measured(void** state) {
    static const int32_t resolutions[SIZES] = {16, 32, 64};
    static truth expected;
    for (int i = 0; i < 4; ++i) {
        const cube_case* c = &cases[i];
        if (c->g > 0 && c->g < 0.9 && !in_full()) continue; /* 0 and 0.96 enclose them */
        ty_scene* scene = cube_in_light(*state, c->g);
        double first = 0;
        trace(scene, c->g, &expected);
        for (int r = 0; r < (in_full() ? SIZES : 2); ++r)
            for (int ratio = 1; ratio <= 2; ++ratio) {
                ty_fld_def def = ty_default_fld_def();
                def.resolution = resolutions[r];
                def.ratio = ratio;
                const error fld = measure(scene, &def, &expected);
                printf("g %.2f, %2d^3 / %d: %.4f / %.4f (mean ratio / relative RMSE; noise %.4f)\n", c->g,
                       resolutions[r], ratio, fld.mean_ratio, fld.rmse, expected.noise);
                const bool coarsest = r == 0 && ratio == 2;
                const double mean = coarsest ? c->coarsest.ratio : c->measured[r - ratio + 1].ratio;
                const double rmse = coarsest ? c->coarsest.rmse : c->measured[r - ratio + 1].rmse;
                assert_true(fabs(fld.mean_ratio - mean) <= ratio_margin);
                assert_true(fld.rmse <= rmse + rmse_margin);
                if (r == 0 && ratio == 1) first = fld.mean_ratio;
                assert_true(fabs(fld.mean_ratio - first) <= 0.03);
            }
        ty_scene_destroy(scene);
    }
}

/* The paper's flux may be as large as the fluence, and its fluence is 0 on the faces. Measured: 1.003 / .089 by
 * default, 0.929 / .127 with the paper's flux, 0.622 / .452 with its faces, too. */
static void the_papers_choices_are_further_off(void** state) {
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
    assert_true(fabs(unlimited.mean_ratio - 0.929) <= ratio_margin && fabs(unlimited.rmse - 0.127) <= rmse_margin);
    assert_true(fabs(paper.mean_ratio - 0.622) <= ratio_margin && fabs(paper.rmse - 0.452) <= rmse_margin);
    assert_true(fabs(ours.mean_ratio - 1.003) <= ratio_margin && ours.rmse <= 0.089 + rmse_margin);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_cube_is_as_bright_as_measured),
                                       cmocka_unit_test(the_papers_choices_are_further_off)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
