/* White furnace: what absorbs nothing, in the same light from everywhere, cannot be seen, whatever its density, phase
 * function and shape. */
#include "truth_cases.h"

static const float white[3] = {1, 1, 1}, coloured[3] = {0.2f, 3, 0.9f};

static ty_scene* furnace_scene(ty_context* context, furnace_body body, double g, const float color[3], bool map) {
    ty_scene* scene = new_scene(context);
    add_furnace_body(scene, body, g);
    add_furnace_light(scene, color, map);
    set_camera(scene, 2, -6, 1, 45);
    return scene;
}

static void check(ty_context* context, const char* what, furnace_body body, double g, bool map, int32_t spp) {
    char name[64];
    const float* color = map || in_full() ? coloured : white;
    ty_scene* scene = furnace_scene(context, body, g, color, map);
    commit(scene);
    snprintf(name, sizeof name, "%s, g %g, %s", what, g, map ? "map" : "constant");
    assert_furnace(name, scene, color, in_full() ? 64 : 32, in_full() ? 1024 : spp);
    ty_scene_destroy(scene);
}

static void check_all(ty_context* context, const char* what, furnace_body body, int32_t spp) {
    static const double g[] = {-0.5, 0, 0.9, -0.9, 0.5, 0.98};
    for (int i = 0; i < (in_full() ? 6 : 3); ++i) {
        check(context, what, body, g[i], false, spp);
        check(context, what, body, g[i], true, spp);
    }
}

static void a_box_is_white(void** state) {
    check_all(*state, "box", FURNACE_BOX, 256);
}

static void a_sphere_is_white(void** state) {
    check_all(*state, "sphere", FURNACE_SPHERE, 256);
}

static void a_plume_is_white(void** state) {
    check_all(*state, "plume", FURNACE_PLUME, 128);
}

static void overlapping_media_are_white(void** state) {
    if (in_full()) check_all(*state, "overlapping media", FURNACE_MANY, 0);
    check(*state, "overlapping media", FURNACE_MANY, 0.4, false, 256);
    check(*state, "overlapping media", FURNACE_MANY, 0.4, true, 256);
}

/* A white ball and a white board in the medium reflect what they get. */
static void white_surfaces_are_white(void** state) {
    for (int map = 0; map < 2; ++map)
        for (int body = 0; body < 2; ++body) {
            ty_scene* scene = furnace_scene(*state, body == 0 ? FURNACE_BOX : FURNACE_MANY, 0.7, coloured, map != 0);
            static const double center[3] = {0.3, -1.2, -0.4}, u[3] = {0.8, 0.6, 0}, v[3] = {0, 0, 1};
            const ty_shape_def ball = sphere_shape(0, 0, 0.1, 0.5, 1, 0), board = square_shape(center, u, v, 0.6, 1);
            add_shape(scene, &ball);
            add_shape(scene, &board);
            commit(scene);
            assert_furnace(map != 0 ? "white ball and board, map" : "white ball and board, constant", scene, coloured,
                           32, 256);
            ty_scene_destroy(scene);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_is_white),           cmocka_unit_test(a_sphere_is_white),
        cmocka_unit_test(a_plume_is_white),         cmocka_unit_test(overlapping_media_are_white),
        cmocka_unit_test(white_surfaces_are_white),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
