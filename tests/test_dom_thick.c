/* dom in media whose cells are many mean free paths thick: a white furnace. A medium that absorbs nothing is invisible
 * in even light, whatever its density. */
#include "checks.h"
#include "effort.h"

#include <tyndall/dom.h>

#include <math.h>

enum { SIDE = 12 };

/* A cube under even light of radiance 1. cell: thickness of its cells, mean free paths. */
static ty_scene* make_cube(ty_context* context, double cell, float g) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(lower, upper, (float)(cell * 12), 0);
    const ty_light_def sky = sky_light(1, 1, 1);
    ty_camera_def camera = ty_default_camera_def();
    set3f(medium.g, g, g, g);
    set3(camera.position, 0, 0, 4);
    set3(camera.target, 0, 0, 0);
    camera.fov_y = 30;
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* Mean radiance of its front. */
static double front(ty_context* context, double cell, float g) {
    ty_scene* scene = make_cube(context, cell, g);
    ty_image* image = NULL;
    ty_dom_def def = ty_default_dom_def();
    def.resolution = fewer_under_sanitizers(24, 3);
    def.width = def.height = SIDE;
    assert_int_equal(ty_dom_render(scene, &def, &image, NULL), TY_OK);
    const float* red = ty_image_plane_const(image, 0);
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) sum += (double)red[i] / (SIDE * SIDE);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    return sum;
}

/* Fluence in the middle of the cube over that of the even light. */
static double middle(ty_context* context, double cell, float g) {
    static const double lower[3] = {-0.2, -0.2, -0.2}, upper[3] = {0.2, 0.2, 0.2};
    static const int32_t one[3] = {1, 1, 1};
    ty_scene* scene = make_cube(context, cell, g);
    ty_dom_def def = ty_default_dom_def();
    ty_dom* light = NULL;
    double fluence[3];
    def.resolution = 24;
    assert_int_equal(ty_dom_solve(scene, &def, &light, NULL), TY_OK);
    assert_int_equal(ty_dom_fluence(light, lower, upper, one, fluence, NULL), TY_OK);
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
    return fluence[0] / (4 * acos(-1));
}

/* Cells that are swept: 1.019 to 1.060 are measured, of the 1.026 that the beams bring. Sources at the centers of cells
 * had 1.20 at 1.25 mean free paths and g 0. */
static void swept_cubes_are_filled(void** state) {
    static const double thickness[] = {1.25, 1.7};
    for (int i = 0; i < 2; ++i)
        for (int g = 0; g < 2; ++g) {
            const double value = middle(*state, thickness[i], 0.5f * (float)g);
            print_message("middle, cells of %g mean free paths, g %g: %.4f\n", thickness[i], 0.5 * g, value);
            assert_close(value, 1.03, 0.05);
        }
}

/* 64 beams stand for the even light, which brings 2.6 % more through the faces than it has; measured are 0.997
 * to 1.018. Cells that scatter evenly where light scatters near their faces had 1.42 at 5 mean free paths, 0.78 at 19.
 */
static void thick_cubes_are_invisible(void** state) {
    skip_under_sanitizers();
    static const double thickness[] = {5, 19, 33};
    for (int i = 0; i < 3; ++i)
        for (int g = 0; g < 2; ++g) {
            const double value = front(*state, thickness[i], 0.5f * (float)g);
            print_message("cells of %g mean free paths, g %g: %.4f\n", thickness[i], 0.5 * g, value);
            if (numbers_count()) assert_close(value, 1.01, 0.025);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(swept_cubes_are_filled),
                                       cmocka_unit_test(thick_cubes_are_invisible)};
    return cmocka_run_group_tests_name("dom_thick", tests, start_context, stop_context);
}
