/* pop in cells many mean free paths thick: a lamp beside fractal noise of 300 mean free paths, whose flux-limited
 * diffusion diverges. Images are finite. */
#include "checks.h"

#include <tyndall/grid.h>
#include <tyndall/pop.h>

enum { SIDE = 8, VOXELS = 32 };

static void divergent_diffusion_is_replaced(void** state) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_context* context = *state;
    ty_noise_def noise = ty_default_noise_def();
    ty_grid* grid = NULL;
    noise.kind = TY_NOISE_FBM;
    for (int a = 0; a < 3; ++a) noise.size[a] = VOXELS;
    noise.frequency = 3;
    noise.octaves = 3;
    assert_int_equal(ty_grid_create_noise(context, &noise, &grid), TY_OK);
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(lower, upper, 135, 15);
    medium.density_grid = grid;
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 1.4, 1.3, 0.8);
    set3f(lamp.color, 10, 10, 10);
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0, 0.5, 4.2);
    set3(camera.target, 0, 0, 0);
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_pop_def def = ty_default_pop_def();
    ty_image* image = NULL;
    def.width = def.height = SIDE;
    assert_int_equal(ty_pop_render(scene, &def, &image, NULL), TY_OK);
    const float* red = ty_image_plane_const(image, 0);
    for (int i = 0; i < SIDE * SIDE; ++i) assert_true(red[i] >= 0 && red[i] < 10);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(divergent_diffusion_is_replaced)};
    return cmocka_run_group_tests_name("pop_thick", tests, start_context, stop_context);
}
