/* Principal-ordinates propagation's calls: arguments, cancelling, memory, progress, threads, views; not whether the
 * light is right. */
#include "volume_calls.h"

#include <stddef.h>

/* Light that other cameras may see. */
static ty_pop_def small_pop(void) {
    ty_pop_def def = ty_default_pop_def();
    def.resolution = 8;
    def.direct = 12;
    def.ordinates = 5;
    def.vpls = 6;
    def.shadow_texels = 16;
    def.keep_lobes = true;
    def.width = WIDTH;
    def.height = HEIGHT;
    return def;
}

/* ---- calls ---- */

VOLUME_CALLS(pop)

static void make_def(volume_def* def, int mode) {
    def->pop = small_pop();
    def->pop.mode = (ty_pop_mode)mode;
}

static ty_result call_fluence(const void* light, const double lower[3], const double upper[3], const int32_t size[3],
                              double* fluence) {
    return ty_pop_fluence(light, lower, upper, size, fluence, NULL);
}

static void look_up_all(const void* light, double numbers[VOLUME_NUMBERS]) {
    static const double lower[3] = {-1.1, -1, -1.2}, upper[3] = {1.1, 1.1, 0.9};
    static const int32_t size[3] = {SIDE, SIDE, SIDE};
    const size_t uncollided = (size_t)3 * CELLS;
    assert_int_equal(ty_pop_fluence(light, lower, upper, size, numbers, numbers + uncollided), TY_OK);
}

static const volume_calls calls = {.name = "pop",
                                   .maker = "ty_default_pop_def",
                                   .variants = 3,
                                   .told = 0.4,
                                   .make_def = make_def,
                                   .watch = watch_def,
                                   .make_scene = foggy_scene,
                                   .solve = call_solve,
                                   .view = call_view,
                                   .render = call_render,
                                   .fluence = call_fluence,
                                   .look_up = look_up_all,
                                   .destroy = call_destroy};

/* ---- arguments ---- */

#define POP(field, type, value, words)                                                                                 \
    { offsetof(ty_pop_def, field), type, value, words }

static const bad_field bad_fields[] = {
    POP(cookie, FIELD_INT, 0, "ty_default_pop_def"),
    POP(mode, FIELD_INT, 3, "pop.mode: 3 is outside [0, 2]"),
    POP(resolution, FIELD_INT, 3, "pop.resolution: 3 is outside [4, 128]"),
    POP(resolution, FIELD_INT, 129, "pop.resolution"),
    POP(merged, FIELD_INT, 3, "pop.merged: 3 is outside [4, 512]"),
    POP(merged, FIELD_INT, 513, "pop.merged"),
    POP(direct, FIELD_INT, -1, "pop.direct: -1 is outside [4, 1024]"),
    POP(direct, FIELD_INT, 1025, "pop.direct"),
    POP(ordinates, FIELD_INT, 0, "pop.ordinates: 0 is outside [1, 4096]"),
    POP(ordinates, FIELD_INT, 4097, "pop.ordinates"),
    POP(prefilter, FIELD_DOUBLE, -1, "pop.prefilter: -1 is outside [0, 16]"),
    POP(prefilter, FIELD_DOUBLE, NAN, "pop.prefilter"),
    POP(surface_points, FIELD_INT, 0, "pop.surface_points: 0 is outside [1, 65536]"),
    POP(vpls, FIELD_INT, -1, "pop.vpls: -1 is outside [0, 4096]"),
    POP(shadow_texels, FIELD_INT, 15, "pop.shadow_texels: 15 is outside [16, 1024]"),
    POP(vpl_min_distance, FIELD_DOUBLE, 1.5, "pop.vpl_min_distance: 1.5 is outside [0, 1]"),
    POP(iterations, FIELD_INT, 10001, "pop.iterations: 10001"),
    POP(residuum, FIELD_DOUBLE, 2, "pop.residuum: 2 is outside [0, 1]"),
    POP(residuum_iterations, FIELD_INT, -1, "pop.residuum_iterations: -1"),
    POP(max_flux_fraction, FIELD_DOUBLE, 1.5, "pop.max_flux_fraction: 1.5 is outside [0, 1]"),
    POP(tolerance, FIELD_DOUBLE, 0, "pop.tolerance: 0 is outside (0, 1)"),
    POP(tolerance, FIELD_DOUBLE, 1, "pop.tolerance"),
    POP(width, FIELD_INT, 0, "pop: 0 x 11"),
    POP(height, FIELD_INT, 65537, "pop: 19 x 65537"),
    POP(spp, FIELD_INT, 65, "pop.spp: 65 is outside [1, 64]"),
    POP(step, FIELD_DOUBLE, 0.01, "pop.step: 0.01 is outside [0.05, 8]"),
    POP(aovs, FIELD_INT, TY_AOV_NORMAL, "pop.aovs: "),
};

static void wrong_defs_are_refused(void** state) {
    check_wrong_defs(&calls, *state, bad_fields, sizeof bad_fields / sizeof *bad_fields);
}

static void scenes_need_media(void** state) {
    check_scenes_without_media(&calls, *state);
}

static void cuts_of_boxes_are_checked(void** state) {
    check_cuts_of_boxes(&calls, *state);
}

/* ---- progress, cancelling, memory ---- */

static void progress_runs_to_the_end(void** state) {
    check_progress(&calls, *state);
}

static void callers_can_cancel_at_any_time(void** state) {
    (void)state;
    for (int mode = 0; mode < 3; ++mode) check_cancelling(&calls, mode);
}

static void refused_memory_leaves_nothing(void** state) {
    (void)state;
    check_refused_memory(&calls);
}

/* ---- results ---- */

static void threads_do_not_change_bits(void** state) {
    (void)state;
    for (int mode = 0; mode < 3; ++mode) {
        volume_def def;
        make_def(&def, mode);
        def.pop.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;
        check_threads(&calls, &def);
    }
}

static void light_outlives_its_scene(void** state) {
    check_lifetimes(&calls, *state);
}

/* A view from another camera position does not change the light: the first view can be had again. */
static void views_do_not_change_light(void** state) {
    for (int variant = 0; variant < calls.variants; ++variant) {
        ty_scene* scene = foggy_scene(*state);
        const ty_camera_def first = ty_scene_camera(scene);
        ty_camera_def second = first;
        set3(second.position, 1, 3, -4);
        const ty_camera_def* const cameras[3] = {&first, &second, &first};
        volume_def def;
        calls.make_def(&def, variant);
        ty_pop* light = solve_volume(&calls, scene, &def);
        ty_image* images[3] = {NULL};
        for (int i = 0; i < 3; ++i) {
            check_result(*state, ty_scene_set_camera(scene, cameras[i]));
            check_result(*state, ty_pop_view(light, scene, &def.pop, &images[i], NULL));
        }
        assert_true(same_images(images[0], images[2]));
        assert_false(same_images(images[0], images[1]));
        for (int i = 0; i < 3; ++i) ty_image_destroy(images[i]);
        ty_pop_destroy(light);
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_defs_are_refused),         cmocka_unit_test(scenes_need_media),
        cmocka_unit_test(cuts_of_boxes_are_checked),      cmocka_unit_test(progress_runs_to_the_end),
        cmocka_unit_test(callers_can_cancel_at_any_time), cmocka_unit_test(refused_memory_leaves_nothing),
        cmocka_unit_test(threads_do_not_change_bits),     cmocka_unit_test(light_outlives_its_scene),
        cmocka_unit_test(views_do_not_change_light),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
