/* Principal-ordinates propagation's calls: arguments, cancelling, memory, progress, threads, views; not whether the
 * light is right. */
#include "volume_calls.h"

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
VOLUME_FLUENCE(pop)

static void make_def(volume_def* def, int mode) {
    def->pop = small_pop();
    def->pop.mode = (ty_pop_mode)mode;
}

static const volume_calls calls = {VOLUME_CALLS_OF(pop), VOLUME_FLUENCE_OF, .variants = 3, .told = 0.4,
                                   .make_scene = foggy_scene};

/* ---- arguments ---- */

static const bad_field bad_fields[] = {VOLUME_BAD_FIELDS(pop)};
static const volume_suite suite = {&calls, bad_fields, sizeof bad_fields / sizeof *bad_fields};

/* ---- results ---- */

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
        VOLUME_TESTS,
        cmocka_unit_test(views_do_not_change_light),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
