/* Environments by discrete ordinates: beams together, and what of them is seen. */
#include "fld_maker.h"

#include <tyndall/dom.h>

#include <stdio.h>

enum { ACROSS = 24, CUT = 6 };

static ty_scene* fog_in_sky(ty_context* context, double half, float sigma_s, float g) {
    const double lower[3] = {-half, -half, -half}, upper[3] = {half, half, half};
    ty_scene* scene = make_scene(context);
    ty_medium_def fog = box_medium(lower, upper, sigma_s, 0);
    ty_light_def sky = ty_default_light_def();
    set3f(fog.g, g, g, g);
    sky.kind = TY_LIGHT_ENVIRONMENT;
    add_medium(scene, &fog);
    add_light(scene, &sky);
    return scene;
}

static ty_dom_def small_dom(void) {
    ty_dom_def def = ty_default_dom_def();
    def.resolution = 12;
    def.direct = 24;
    def.width = def.height = ACROSS;
    return def;
}

static void render_fluence(const ty_scene* scene, const ty_dom_def* def, double* fluence, ty_image** image) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    const int32_t size[3] = {CUT, CUT, CUT};
    ty_dom* light = NULL;
    check_result(ty_scene_context(scene), ty_dom_solve(scene, def, &light, NULL));
    check_result(ty_scene_context(scene), ty_dom_fluence(light, lower, upper, size, fluence, NULL));
    check_result(ty_scene_context(scene), ty_dom_view(light, scene, def, image, NULL));
    ty_dom_destroy(light);
}

/* Beams whose moments are added together (13 of them: not as many as go together) are what they are one by one, which
 * is how they are taken where g is not the same everywhere: here it differs within rounding. */
static void beams_together_are_beams_one_by_one(void** state) {
    static double fluence[2][3 * CUT * CUT * CUT];
    ty_image* image[2] = {NULL, NULL};
    ty_dom_def def = small_dom();
    def.environment_beams = 13;
    for (int i = 0; i < 2; ++i) {
        const double lower[3] = {-1, -1, -1}, upper[3] = {0, 1, 1};
        ty_scene* scene = fog_in_sky(*state, 1, 2, 0.6f);
        ty_medium_def haze = box_medium(lower, upper, 1, 0.2f);
        const float g = i == 0 ? 0.6f : 0.60005f;
        set3f(haze.g, g, g, g);
        add_medium(scene, &haze);
        commit(scene);
        render_fluence(scene, &def, fluence[i], &image[i]);
        ty_scene_destroy(scene);
    }
    for (int i = 0; i < 3 * CUT * CUT * CUT; ++i)
        assert_true(fabs(fluence[1][i] - fluence[0][i]) <= 2e-3 * fluence[0][i]);
    for (int i = 0; i < ACROSS * ACROSS; ++i)
        assert_close((double)ty_image_plane_const(image[1], 0)[i], (double)ty_image_plane_const(image[0], 0)[i], 2e-3);
    ty_image_destroy(image[0]);
    ty_image_destroy(image[1]);
}

/* A white furnace: light alike from everywhere shows nothing of what absorbs nothing; narrow lobes nearly, though 64
 * beams are 25 degrees apart. */
static void beams_leave_no_gaps(void** state) {
    static double fluence[3 * CUT * CUT * CUT];
    ty_image* image = NULL;
    ty_scene* scene = fog_in_sky(*state, 0.5, 3, 0.9f);
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 2, 1.5, -2.5);
    set3(camera.target, 0, 0, 0);
    camera.fov_y = 32;
    check_result(*state, ty_scene_set_camera(scene, &camera));
    commit(scene);
    ty_dom_def def = small_dom();
    def.resolution = 24;
    def.direct = 64;
    def.spp = 4;
    render_fluence(scene, &def, fluence, &image);
    double sum = 0, squares = 0;
    int count = 0;
    for (int i = 0; i < ACROSS * ACROSS; ++i) {
        const double off = (double)ty_image_plane_const(image, 0)[i] - 1;
        if (fabs(off) < 1e-6) continue;
        sum += off;
        squares += off * off;
        ++count;
    }
    assert_true(count > ACROSS);
    printf("white furnace, g 0.9: mean %.4f off, rms %.4f\n", sum / count, sqrt(squares / count));
    assert_true(fabs(sum / count) <= 0.015 && sqrt(squares / count) <= 0.03);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(beams_together_are_beams_one_by_one),
                                       cmocka_unit_test(beams_leave_no_gaps)};
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
