/* Flux-limited diffusion's calls: arguments, cancelling, memory, progress, threads, views; not whether the light is
 * right. */
#include "volume_calls.h"

#include <stddef.h>

/* ---- calls ---- */

VOLUME_CALLS(fld)

static void make_def(volume_def* def, int solver) {
    def->fld = small_fld();
    def->fld.solver = (ty_fld_solver)solver;
}

static ty_result call_fluence(const void* light, const double lower[3], const double upper[3], const int32_t size[3],
                              double* fluence) {
    return ty_fld_fluence(light, lower, upper, size, fluence, NULL, NULL);
}

static void look_up_all(const void* light, double numbers[VOLUME_NUMBERS]) {
    cell_light all;
    look_up(light, &all);
    memcpy(numbers, &all, sizeof all);
}

static const volume_calls calls = {VOLUME_CALLS_OF(fld), .variants = 3, .told = 0.5, .make_scene = foggy_scene};

/* ---- arguments ---- */

#define FLD(field, type, value, words)                                                                                 \
    { offsetof(ty_fld_def, field), type, value, words }

static const bad_field bad_fields[] = {
    FLD(cookie, FIELD_INT, 0, "ty_default_fld_def"),
    FLD(resolution, FIELD_INT, 3, "fld.resolution: 3 is outside [4, 1024]"),
    FLD(resolution, FIELD_INT, 1025, "fld.resolution"),
    FLD(resolution, FIELD_INT, -1, "fld.resolution"),
    FLD(ratio, FIELD_DOUBLE, 0.5, "fld.ratio: 0.5 is outside [1, 64]"),
    FLD(ratio, FIELD_DOUBLE, 65, "fld.ratio"),
    FLD(ratio, FIELD_DOUBLE, NAN, "fld.ratio"),
    FLD(beam, FIELD_INT, 2, "fld.beam: there is none with number 2"),
    FLD(beam, FIELD_INT, -1, "fld.beam"),
    FLD(limiter, FIELD_INT, 6, "fld.limiter: there is none with number 6"),
    FLD(limiter, FIELD_INT, -1, "fld.limiter"),
    FLD(larsen_power, FIELD_DOUBLE, 0.9, "fld.larsen_power: 0.9 is outside [1, 100]"),
    FLD(larsen_power, FIELD_DOUBLE, 101, "fld.larsen_power"),
    FLD(streaming, FIELD_DOUBLE, -0.1, "fld.streaming: -0.1 is outside [0, 1]"),
    FLD(streaming, FIELD_DOUBLE, 1.01, "fld.streaming"),
    FLD(streaming, FIELD_DOUBLE, NAN, "fld.streaming"),
    FLD(boundary, FIELD_INT, 2, "fld.boundary: there is none with number 2"),
    FLD(sigma_eps, FIELD_DOUBLE, -1, "fld.sigma_eps: -1"),
    FLD(sigma_eps, FIELD_DOUBLE, INFINITY, "fld.sigma_eps"),
    FLD(solver, FIELD_INT, 3, "fld.solver: there is none with number 3"),
    FLD(relaxation, FIELD_DOUBLE, 0, "fld.relaxation: 0 is outside (0, 2)"),
    FLD(relaxation, FIELD_DOUBLE, 2, "fld.relaxation"),
    FLD(tolerance, FIELD_DOUBLE, 0, "fld.tolerance: 0 is outside (0, 1)"),
    FLD(tolerance, FIELD_DOUBLE, 1, "fld.tolerance"),
    FLD(tolerance, FIELD_DOUBLE, NAN, "fld.tolerance"),
    FLD(iterations, FIELD_INT, -1, "fld.iterations: -1"),
    FLD(environment_beams, FIELD_INT, 0, "fld.environment_beams: 0 is outside [1, 65536]"),
    FLD(environment_beams, FIELD_INT, 65537, "fld.environment_beams"),
    FLD(surface_points, FIELD_INT, 0, "fld.surface_points: 0 is outside [1, 65536]"),
    FLD(surface_points, FIELD_INT, 65537, "fld.surface_points"),
    FLD(width, FIELD_INT, 0, "fld: 0 x 11"),
    FLD(height, FIELD_INT, 0, "fld: 19 x 0"),
    FLD(width, FIELD_INT, -5, "fld: -5 x 11"),
    FLD(height, FIELD_INT, 65537, "fld: 19 x 65537"),
    FLD(spp, FIELD_INT, 0, "fld.spp: 0 is outside [1, 64]"),
    FLD(spp, FIELD_INT, 65, "fld.spp"),
    FLD(step, FIELD_DOUBLE, 0.01, "fld.step: 0.01 is outside [0.05, 8]"),
    FLD(step, FIELD_DOUBLE, 9, "fld.step"),
    FLD(aovs, FIELD_INT, TY_AOV_NORMAL, "fld.aovs: "),
};

static const volume_suite suite = {&calls, bad_fields, sizeof bad_fields / sizeof *bad_fields};

static void defaults_are_as_documented(void** state) {
    (void)state;
    const ty_fld_def def = ty_default_fld_def();
    assert_int_equal(def.resolution, 0);
    assert_true(def.ratio == 0 && def.larsen_power == 2 && def.streaming == 0 && def.sigma_eps == 0);
    assert_true(def.relaxation == 1.85 && def.tolerance == 1e-3 && def.step == 1);
    assert_int_equal(def.beam, TY_FLD_BEAM_REDUCED);
    assert_int_equal(def.limiter, TY_FLD_LIMITER_LEVERMORE_POMRANING);
    assert_int_equal(def.boundary, TY_FLD_BOUNDARY_MARSHAK);
    assert_int_equal(def.solver, TY_FLD_SOLVER_MULTIGRID);
    assert_int_equal(def.iterations, 0);
    assert_int_equal(def.environment_beams, 64);
    assert_int_equal(def.surface_points, 16);
    assert_int_equal(def.spp, 1);
    assert_int_equal(def.width | def.height | (int32_t)def.aovs, 0);
    assert_true(def.seed == 0 && def.unscattered == NULL && def.progress == NULL);
}

/* ---- what is reported ---- */

/* Fog with voxels has its own resolution; without, 64 cells and a half of them for diffusion. */
static void statistics_tell_what_was_done(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_fld_def def = small_fld();
    ty_fld_stats stats;
    ty_image* image = NULL;
    check_result(*state, ty_fld_render(scene, &def, &image, &stats));
    for (int a = 0; a < 3; ++a) {
        assert_int_equal(stats.direct_size[a], 12);
        assert_int_equal(stats.diffusion_size[a], 6);
    }
    assert_int_equal(stats.planes, 3); /* g of the first channel is another */
    assert_true(stats.converged && stats.isa != NULL && stats.bytes > 0);
    for (int c = 0; c < 3; ++c) {
        assert_true(stats.iterations[c] >= 1 && stats.cycles[c] >= 1 && stats.work[c] >= 1);
        assert_true(stats.residual[c] <= def.tolerance && stats.emitted[c] > 0);
    }
    /* The stages run one after another, so that their times add up to no more than the call's, and are most of it. */
    const double stages[] = {stats.medium_seconds, stats.direct_seconds, stats.solve_seconds, stats.march_seconds};
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        assert_true(stages[i] > 0);
        sum += stages[i];
    }
    if (!(sum <= stats.seconds + 1e-6 && sum >= 0.5 * stats.seconds))
        fail_msg("stages take %g of %g s", sum, stats.seconds);
    ty_image_destroy(image);
    def.resolution = 0;
    def.ratio = 0;
    ty_fld_destroy(solve(scene, &def, &stats));
    assert_int_equal(stats.direct_size[0], 64);
    assert_int_equal(stats.diffusion_size[0], 32);
    ty_scene_destroy(scene);
}

static void running_out_of_iterations_is_told(void** state) {
    ty_scene* scene = foggy_scene(*state);
    for (int solver = 0; solver < 3; ++solver) {
        ty_fld_def def = small_fld();
        ty_fld_stats stats;
        def.solver = (ty_fld_solver)solver;
        def.iterations = 1;
        def.tolerance = 1e-12;
        ty_fld_destroy(solve(scene, &def, &stats));
        assert_false(stats.converged);
        assert_int_equal(stats.iterations[0], 1);
        assert_true(stats.residual[0] > def.tolerance);
    }
    ty_scene_destroy(scene);
}

/* ---- results ---- */

static void threads_do_not_change_bits(void** state) {
    (void)state;
    volume_def def = {.fld = small_fld()};
    def.fld.resolution = 40;
    def.fld.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;
    check_threads(&calls, &def);
}

/* R, G, B are what was scattered, and what surfaces sent. */
static void channels_add_up(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_fld_def def = small_fld();
    def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;
    ty_image *image = NULL, *surfaces = NULL;
    check_result(*state, ty_image_create_rgb(*state, WIDTH, HEIGHT, &surfaces));
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < PIXELS; ++i) ty_image_plane(surfaces, c)[i] = (float)(c + i) / PIXELS;
    def.unscattered = surfaces;
    check_result(*state, ty_fld_render(scene, &def, &image, NULL));
    const int32_t single = ty_image_find_channel(image, "single.R");
    const int32_t multiple = ty_image_find_channel(image, "multiple.R");
    const int32_t transmittance = ty_image_find_channel(image, "transmittance.R");
    assert_int_equal(ty_image_channel_count(image), 13);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < PIXELS; ++i) {
            const double sum = (double)ty_image_plane_const(image, single + c)[i] +
                               (double)ty_image_plane_const(image, multiple + c)[i] +
                               (double)ty_image_plane_const(surfaces, c)[i];
            assert_close((double)ty_image_plane_const(image, c)[i], sum, 1e-5 * sum);
            const float passed = ty_image_plane_const(image, transmittance + c)[i];
            assert_true(passed >= 0 && passed <= 1);
        }
    ty_image_destroy(image);
    def.width = 2 * WIDTH;
    assert_int_equal(ty_fld_render(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "unscattered: 19 x 11 pixels, and the image has 38 x 11");
    ty_image_destroy(surfaces);
    ty_scene_destroy(scene);
}

/* What light was solved with stays with it. */
static void views_know_the_beam_of_their_light(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_fld_def def = small_fld();
    def.beam = TY_FLD_BEAM_PUBLISHED;
    ty_fld* light = solve(scene, &def, NULL);
    ty_image *a = NULL, *b = NULL;
    check_result(*state, ty_fld_view(light, scene, &def, &a, NULL));
    def.beam = TY_FLD_BEAM_REDUCED;
    check_result(*state, ty_fld_view(light, scene, &def, &b, NULL));
    assert_true(same_images(a, b));
    ty_image_destroy(a);
    ty_image_destroy(b);
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        VOLUME_TESTS,
        cmocka_unit_test(cameras_move_without_solving_again),
        cmocka_unit_test(defaults_are_as_documented),
        cmocka_unit_test(statistics_tell_what_was_done),
        cmocka_unit_test(running_out_of_iterations_is_told),
        cmocka_unit_test(threads_do_not_change_bits),
        cmocka_unit_test(channels_add_up),
        cmocka_unit_test(views_know_the_beam_of_their_light),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
