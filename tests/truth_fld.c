/* Flux-limited diffusion's fluence against path tracing's: the unit cube in parallel light. */
#include "truth.h"

enum { COARSE = 16, CELLS = COARSE * COARSE * COARSE };

static const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
static const int32_t coarse[3] = {COARSE, COARSE, COARSE};
static const double anisotropies[] = {0, 0.5, 0.7, 0.96};

/* sigma_s = 4/m and no absorption; light of 1 W m^-2 comes down. */
static ty_scene* cube_in_light(ty_context* context, double g) {
    ty_scene* scene = new_scene(context);
    ty_medium_def medium = medium_cube(0.5, 4, 0, g);
    for (int a = 0; a < 3; ++a) {
        medium.box_min[a] = 0;
        medium.box_max[a] = 1;
    }
    add_medium(scene, &medium);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    set3(sun.direction, 0, -1, 0);
    add_light(scene, &sun);
    commit(scene);
    return scene;
}

/* Scattered light alone, a channel of each cell. */
typedef struct truth {
    double scattered[CELLS], uncollided[CELLS], noise; /* noise: relative RMSE of scattered */
} truth;

static void trace(const ty_scene* scene, truth* out) {
    const int32_t spp = 512;
    double* runs[2] = {new_numbers(3 * CELLS), new_numbers(3 * CELLS)};
    double* uncollided = new_numbers(3 * CELLS);
    double sum = 0, square = 0;
    for (int run = 0; run < 2; ++run) {
        ty_path_def def = ty_default_path_def();
        def.spp = spp;
        def.seed = (uint64_t)run;
        must(ty_scene_context(scene), ty_path_fluence(scene, &def, low, high, coarse, runs[run], uncollided, NULL));
    }
    for (int i = 0; i < CELLS; ++i) {
        const double y = (i / COARSE % COARSE + 0.5) / COARSE;
        out->uncollided[i] = exp(-4 * (1 - y)) * sinh(2.0 / COARSE) / (2.0 / COARSE);
        out->scattered[i] = 0.5 * (runs[0][3 * i] + runs[1][3 * i]) - out->uncollided[i];
        sum += out->scattered[i];
        square += 0.25 * pow(runs[0][3 * i] - runs[1][3 * i], 2);
    }
    out->noise = sqrt(square / CELLS) / (sum / CELLS);
    free(runs[0]);
    free(runs[1]);
    free(uncollided);
}

typedef struct error {
    double mean_ratio, rmse;
} error;

static error measure(const ty_scene* scene, const ty_fld_def* def, const truth* expected) {
    ty_context* context = ty_scene_context(scene);
    double* fluence = new_numbers(3 * CELLS);
    double* flux = new_numbers(9 * CELLS);
    ty_fld* light = NULL;
    ty_fld_stats stats;
    must(context, ty_fld_solve(scene, def, &light, &stats));
    must(context, ty_fld_fluence(light, low, high, coarse, fluence, NULL, flux));
    assert_true(stats.converged);
    double sum = 0, truth_sum = 0, square = 0;
    for (int i = 0; i < CELLS; ++i) {
        const double value = fluence[3 * i] - expected->uncollided[i];
        sum += value;
        truth_sum += expected->scattered[i];
        square += pow(value - expected->scattered[i], 2);
        const double length =
            sqrt(flux[9 * i] * flux[9 * i] + flux[9 * i + 1] * flux[9 * i + 1] + flux[9 * i + 2] * flux[9 * i + 2]);
        if (!(length <= fluence[3 * i] * (1 + 1e-5)))
            fail_msg("cell %d: flux %g, fluence %g", i, length, fluence[3 * i]);
    }
    if (!(fabs(stats.absorbed[0] + stats.leaving[0] - stats.emitted[0]) <= 1e-3 * stats.emitted[0]))
        fail_msg("emitted %g, absorbed %g, leaving %g", stats.emitted[0], stats.absorbed[0], stats.leaving[0]);
    ty_fld_destroy(light);
    free(fluence);
    free(flux);
    const double mean = truth_sum / CELLS;
    return (error){sum / truth_sum, sqrt(fmax(0, square / CELLS - pow(expected->noise * mean, 2))) / mean};
}

/* Whatever the resolution, and half as fine for diffusion, the answer is the same. */
static void test_cube(void** state) {
    static const int32_t resolutions[] = {16, 32, 64};
    static truth expected;
    for (int i = 0; i < 4; ++i) {
        ty_scene* scene = cube_in_light(*state, anisotropies[i]);
        double first = 0;
        trace(scene, &expected);
        for (int r = 0; r < 3; ++r)
            for (int ratio = 1; ratio <= 2; ++ratio) {
                ty_fld_def def = ty_default_fld_def();
                def.resolution = resolutions[r];
                def.ratio = ratio;
                const error fld = measure(scene, &def, &expected);
                def.limiter = TY_FLD_LIMITER_NONE;
                const error cda = measure(scene, &def, &expected);
                printf(
                    "g %.2f, %2d^3 / %d: fld %.4f / %.4f, cda %.4f / %.4f (mean ratio / relative RMSE; noise %.4f)\n",
                    anisotropies[i], resolutions[r], ratio, fld.mean_ratio, fld.rmse, cda.mean_ratio, cda.rmse,
                    expected.noise);
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
    trace(scene, &expected);
    ty_fld_def def = ty_default_fld_def();
    def.resolution = 32;
    def.ratio = 1;
    const error ours = measure(scene, &def, &expected);
    def.streaming = 1;
    const error streaming = measure(scene, &def, &expected);
    def.boundary = TY_FLD_BOUNDARY_DIRICHLET;
    const error paper = measure(scene, &def, &expected);
    printf("g 0, 32^3: ours %.4f / %.4f, streaming 1 %.4f / %.4f, and no fluence on the faces %.4f / %.4f\n",
           ours.mean_ratio, ours.rmse, streaming.mean_ratio, streaming.rmse, paper.mean_ratio, paper.rmse);
    assert_true(ours.rmse < streaming.rmse && streaming.rmse < paper.rmse);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cube), cmocka_unit_test(test_published)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
