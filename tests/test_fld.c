/* Flux-limited diffusion's calls: arguments, cancelling, memory, progress, threads, views; not whether the light is
 * right. */
#include "volume_calls.h"

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

static const volume_calls calls = {VOLUME_CALLS_OF(fld), VOLUME_FLUENCE_OF, .variants = 3,
                                   .resolution = 40,     .told = 0.5,       .make_scene = foggy_scene};

/* ---- arguments ---- */

static const bad_field bad_fields[] = {VOLUME_BAD_FIELDS(fld)};
static const volume_suite suite = {&calls, bad_fields, sizeof bad_fields / sizeof *bad_fields};

/* ---- what is reported ---- */

/* Fog with voxels has its own resolution; without, 64 cells and a half of them for diffusion. */
static void statistics_tell_what_was_done(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_fld_def def = small_fld();
    ty_fld_stats stats = ty_default_fld_stats();
    ty_image* image = NULL;
    check_result(*state, ty_fld_render(scene, &def, &image, &stats));
    for (int a = 0; a < 3; ++a) {
        assert_int_equal(stats.direct_size[a], 12);
        assert_int_equal(stats.diffusion_size[a], 6);
    }
    assert_int_equal(stats.planes, 3); /* g of the first channel is another */
    assert_true(stats.converged && stats.isa != NULL && stats.memory_bytes > 0);
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
    def.resolution = TY_AUTO;
    def.ratio = TY_AUTO;
    ty_fld_destroy(solve(scene, &def, &stats));
    assert_int_equal(stats.direct_size[0], 64);
    assert_int_equal(stats.diffusion_size[0], 32);
    ty_scene_destroy(scene);
}

static void running_out_of_iterations_is_told(void** state) {
    ty_scene* scene = foggy_scene(*state);
    for (int solver = 0; solver < 3; ++solver) {
        ty_fld_def def = small_fld();
        ty_fld_stats stats = ty_default_fld_stats();
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

/* The options of a solve stay with its light. */
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
        cmocka_unit_test(statistics_tell_what_was_done),
        cmocka_unit_test(running_out_of_iterations_is_told),
        cmocka_unit_test(channels_add_up),
        cmocka_unit_test(views_know_the_beam_of_their_light),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
