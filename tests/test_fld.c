/* Flux-limited diffusion's calls: arguments, cancelling, memory, progress, threads, views; not whether the light is
 * right. */
#include "files.h"
#include "fld_maker.h"

#include <stddef.h>

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

/* Every call says the same of a def, and hands nothing out. */
static void refuse(const ty_scene* scene, const ty_fld* light, const ty_fld_def* def, const char* words) {
    ty_context* context = ty_scene_context(scene);
    ty_fld* other = NULL;
    ty_image* image = (ty_image*)(uintptr_t)1;
    assert_int_equal(ty_fld_solve(scene, def, &other, NULL), TY_ERROR_ARGUMENT);
    assert_null(other);
    assert_error(context, words);
    assert_int_equal(ty_fld_render(scene, def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_null(image);
    assert_error(context, words);
    image = (ty_image*)(uintptr_t)1;
    assert_int_equal(ty_fld_view(light, scene, def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_null(image);
    assert_error(context, words);
}

static void wrong_defs_are_refused(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_fld_def def = small_fld();
    ty_fld* light = solve(scene, &def, NULL);
    for (size_t i = 0; i < sizeof bad_fields / sizeof *bad_fields; ++i) {
        def = small_fld();
        set_field(&def, &bad_fields[i]);
        refuse(scene, light, &def, bad_fields[i].words);
    }
    refuse(scene, light, NULL, "ty_default_fld_def");
    ty_fld_destroy(light);
    ty_fld_destroy(NULL);
    ty_scene_destroy(scene);
}

static void scenes_need_media(void** state) {
    ty_scene* scene = make_scene(*state);
    const ty_fld_def def = small_fld();
    ty_fld* light = NULL;
    ty_image* image = NULL;
    assert_int_equal(ty_fld_solve(scene, &def, &light, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "not committed");
    commit(scene);
    assert_int_equal(ty_fld_solve(scene, &def, &light, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fld: the scene has no media");
    assert_int_equal(ty_fld_render(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fld: the scene has no media");
    assert_null(light);
    assert_null(image);
    ty_scene_destroy(scene);
}

static void cuts_of_boxes_are_checked(void** state) {
    static const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1}, odd[3] = {0, NAN, 0};
    static const int32_t size[3] = {1, 1, 1}, none[3] = {1, 0, 1}, many[3] = {1, 1, 65537};
    ty_scene* scene = foggy_scene(*state);
    const ty_fld_def def = small_fld();
    ty_fld* light = solve(scene, &def, NULL);
    double out[3];
    assert_int_equal(ty_fld_fluence(light, one, zero, size, out, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fluence: 1 cells from 1 to 0 m");
    assert_int_equal(ty_fld_fluence(light, zero, one, none, out, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fluence: 0 cells");
    assert_int_equal(ty_fld_fluence(light, zero, one, many, out, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fluence: 65537 cells");
    assert_int_equal(ty_fld_fluence(light, odd, one, size, out, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fluence: lower");
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

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
    const double parts = stats.medium_seconds + stats.direct_seconds + stats.solve_seconds + stats.march_seconds;
    assert_close(stats.seconds, parts, 0.5 * parts);
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

/* ---- progress, cancelling, memory ---- */

typedef struct watch {
    int calls, stop_at; /* 0: never */
    double fraction;
    bool strange;
} watch;

static bool look(void* user, const ty_progress* progress) {
    watch* w = user;
    w->strange = w->strange || !(progress->fraction >= w->fraction - 1e-12 && progress->fraction <= 1 + 1e-12) ||
                 !(progress->seconds >= 0) || progress->stage == NULL;
    w->fraction = progress->fraction;
    return ++w->calls != w->stop_at;
}

static void progress_runs_to_the_end(void** state) {
    ty_scene* scene = foggy_scene(*state);
    for (int solver = 0; solver < 3; ++solver) {
        watch w = {.calls = 0};
        ty_fld_def def = small_fld();
        def.solver = (ty_fld_solver)solver;
        def.progress = look;
        def.progress_user = &w;
        ty_image* image = NULL;
        check_result(*state, ty_fld_render(scene, &def, &image, NULL));
        assert_true(w.calls >= 3 && !w.strange);
        assert_close(w.fraction, 1, 1e-9);
        ty_image_destroy(image);
        w = (watch){.calls = 0};
        ty_fld* light = solve(scene, &def, NULL);
        assert_true(w.calls >= 3 && !w.strange && w.fraction >= 0.5);
        w = (watch){.calls = 0};
        check_result(*state, ty_fld_view(light, scene, &def, &image, NULL));
        assert_true(w.calls >= 1 && !w.strange);
        assert_close(w.fraction, 1, 1e-9);
        ty_image_destroy(image);
        ty_fld_destroy(light);
    }
    ty_scene_destroy(scene);
}

/* Whoever says no at any time gets nothing, and all memory back. */
static void callers_can_cancel_at_any_time(void** state) {
    (void)state;
    for (int solver = 0; solver < 2; ++solver) {
        strict_memory memory = {.limit = (size_t)1 << 28, .until_refusal = -1};
        ty_context* context = strict_context(&memory);
        ty_scene* scene = foggy_scene(context);
        ty_fld_def def = small_fld();
        def.solver = (ty_fld_solver)solver;
        def.progress = look;
        ty_result result = TY_CANCELLED;
        int stop = 0;
        for (stop = 1; result == TY_CANCELLED; ++stop) {
            watch w = {.stop_at = stop};
            ty_image* image = (ty_image*)(uintptr_t)1;
            const size_t before = memory.used;
            def.progress_user = &w;
            result = ty_fld_render(scene, &def, &image, NULL);
            if (result != TY_CANCELLED) {
                check_result(context, result);
                ty_image_destroy(image);
                break;
            }
            assert_int_equal(w.calls, stop);
            assert_null(image);
            assert_int_equal(memory.used, before);
            assert_string_equal(ty_last_error(context), "");
        }
        assert_true(stop >= 4);
        ty_scene_destroy(scene);
        ty_context_destroy(context);
        assert_int_equal(memory.used, 0);
    }
}

static void refused_memory_leaves_nothing(void** state) {
    (void)state;
    strict_memory memory = {.limit = (size_t)1 << 28, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    ty_scene* scene = foggy_scene(context);
    const ty_fld_def def = small_fld();
    ty_image* image = NULL;
    check_result(context, ty_fld_render(scene, &def, &image, NULL)); /* starts the context's threads */
    ty_image_destroy(image);
    ty_result result = TY_ERROR_MEMORY;
    int count = 0;
    for (; result == TY_ERROR_MEMORY; ++count) {
        const size_t before = memory.used;
        memory.until_refusal = count;
        image = NULL;
        result = ty_fld_render(scene, &def, &image, NULL);
        memory.until_refusal = -1;
        if (result == TY_OK) break;
        assert_int_equal(result, TY_ERROR_MEMORY);
        assert_null(image);
        assert_int_equal(memory.used, before);
        assert_error(context, "memory");
    }
    check_result(context, result);
    assert_true(count > 30);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    assert_int_equal(memory.used, 0);
}

/* ---- results ---- */

static void threads_do_not_change_bits(void** state) {
    (void)state;
    static const int32_t threads[] = {1, 2, 4};
    static cell_light light[2];
    ty_image* first = NULL;
    ty_context* contexts[3];
    for (int i = 0; i < 3; ++i) {
        contexts[i] = make_context(threads[i]);
        ty_scene* scene = foggy_scene(contexts[i]);
        ty_fld_def def = small_fld();
        def.resolution = 40;
        def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;
        ty_image* image = NULL;
        check_result(contexts[i], ty_fld_render(scene, &def, &image, NULL));
        solve_cells(scene, &def, &light[i > 0], NULL);
        if (i == 0) first = image;
        if (i > 0) {
            assert_true(same_images(image, first));
            assert_memory_equal(&light[1], &light[0], sizeof light[0]);
            ty_image_destroy(image);
        }
        ty_scene_destroy(scene);
    }
    ty_image_destroy(first);
    for (int i = 0; i < 3; ++i) ty_context_destroy(contexts[i]);
}

/* Light that was solved once is seen from where the camera is moved to, as if it had been solved there. */
static void cameras_move_without_solving_again(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_fld_def def = small_fld();
    ty_fld* light = solve(scene, &def, NULL);
    ty_image* images[3] = {NULL};
    ty_camera_def camera = ty_scene_camera(scene);
    check_result(*state, ty_fld_view(light, scene, &def, &images[0], NULL));
    set3(camera.position, 1, 3, -4);
    check_result(*state, ty_scene_set_camera(scene, &camera));
    check_result(*state, ty_fld_view(light, scene, &def, &images[1], NULL));
    check_result(*state, ty_fld_render(scene, &def, &images[2], NULL));
    assert_true(same_images(images[1], images[2]));
    assert_false(same_images(images[0], images[1]));
    for (int i = 0; i < 3; ++i) ty_image_destroy(images[i]);
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
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
        cmocka_unit_test(wrong_defs_are_refused),
        cmocka_unit_test(scenes_need_media),
        cmocka_unit_test(cuts_of_boxes_are_checked),
        cmocka_unit_test(defaults_are_as_documented),
        cmocka_unit_test(statistics_tell_what_was_done),
        cmocka_unit_test(running_out_of_iterations_is_told),
        cmocka_unit_test(progress_runs_to_the_end),
        cmocka_unit_test(callers_can_cancel_at_any_time),
        cmocka_unit_test(refused_memory_leaves_nothing),
        cmocka_unit_test(threads_do_not_change_bits),
        cmocka_unit_test(cameras_move_without_solving_again),
        cmocka_unit_test(channels_add_up),
        cmocka_unit_test(views_know_the_beam_of_their_light),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
