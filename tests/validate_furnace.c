/* The long form of truth_furnace.c: more samples, larger pictures, more g. */
#include "truth_cases.h"

static void check_body(ty_context* context, const char* what, furnace_body body) {
    static const double anisotropies[] = {-0.9, -0.5, 0, 0.5, 0.9, 0.98};
    static const float color[3] = {0.2f, 3, 0.9f};
    for (int i = 0; i < 6; ++i)
        for (int map = 0; map < 2; ++map) {
            char name[64];
            snprintf(name, sizeof name, "%s, g %g, %s", what, anisotropies[i], map != 0 ? "map" : "constant");
            ty_scene* scene = new_scene(context);
            add_furnace_body(scene, body, anisotropies[i]);
            add_furnace_light(scene, color, map != 0);
            set_camera(scene, 2, -6, 1, 45);
            commit(scene);
            assert_furnace(name, scene, color, 64, 1024);
            ty_scene_destroy(scene);
        }
}

static void test_box(void** state) {
    check_body(*state, "box", FURNACE_BOX);
}

static void test_sphere(void** state) {
    check_body(*state, "sphere", FURNACE_SPHERE);
}

static void test_plume(void** state) {
    check_body(*state, "plume", FURNACE_PLUME);
}

static void test_overlapping_media(void** state) {
    check_body(*state, "overlapping media", FURNACE_MANY);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_box),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_plume),
        cmocka_unit_test(test_overlapping_media),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
