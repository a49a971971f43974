/* Cameras with shift, a thin lens and motion: the rays of each, and their images by path and by the marcher. */
#include "fog.h"
#include "scene/camera.h"

#include <math.h>
#include <tyndall/dom.h>
#include <tyndall/lpv.h>

static double length_of(ty_vec v) {
    return sqrt((double)ty_dot(v, v));
}

static ty_camera_def odd_camera(void) {
    ty_camera_def def = ty_default_camera_def();
    set3(def.position, 1, 2, 3);
    set3(def.target, -1, 0.5, -2);
    set3(def.up, 0.2, 1, 0.1);
    def.fov_y = 35;
    return def;
}

static void assert_same_direction(ty_vec a, ty_vec b) {
    assert_close(a.x, b.x, 2e-6);
    assert_close(a.y, b.y, 2e-6);
    assert_close(a.z, b.z, 2e-6);
}

static void shift_is_a_fraction_of_the_height(void** state) {
    (void)state;
    ty_camera_def def = odd_camera();
    const ty_camera_view plain = ty_camera_get_view(&def, 40, 20);
    def.shift[0] = 0.25;
    def.shift[1] = -0.1;
    const ty_camera_view shifted = ty_camera_get_view(&def, 40, 20);
    assert_int_equal(shifted.sampled, 0);
    assert_same_direction(ty_camera_direction(&shifted, 7, 3), ty_camera_direction(&plain, 12, 5));
}

/* The point of the plane in focus that a camera sees at (x, y). */
static ty_vec in_focus(const ty_camera_view* camera, float x, float y, ty_vec eye, ty_vec axis, float focus) {
    const ty_vec direction = ty_camera_direction(camera, x, y);
    const ty_vec off = ty_sub(eye, camera->origin);
    return ty_mad(camera->origin, direction, (focus + ty_dot(off, axis)) / ty_dot(direction, axis));
}

static void all_points_of_a_lens_see_the_plane_in_focus_alike(void** state) {
    (void)state;
    ty_camera_def def = odd_camera();
    const ty_camera_view pinhole = ty_camera_get_view(&def, 40, 20);
    const ty_vec axis = ty_camera_direction(&pinhole, 20, 10);
    def.aperture_radius = 0.3;
    def.focus_distance = 4;
    const ty_camera_view lens = ty_camera_get_view(&def, 40, 20);
    const ty_vec expected = in_focus(&pinhole, 31, 4, pinhole.origin, axis, 4);
    double squares = 0;
    assert_int_equal(lens.sampled, 1);
    for (int i = 0; i < 64; ++i) {
        const ty_camera_view one = ty_camera_sample(&lens, ((float)i + 0.5f) / 64, 0.618034f * (float)i, 0.5f);
        const ty_vec at = in_focus(&one, 31, 4, pinhole.origin, axis, 4), off = ty_sub(one.origin, pinhole.origin);
        assert_close(length_of(ty_sub(at, expected)), 0, 2e-5);
        assert_close(ty_dot(off, axis), 0, 1e-6);
        squares += (double)ty_dot(off, off);
    }
    assert_close(squares / 64, 0.3 * 0.3 / 2, 1e-4); /* uniform on the disk */
}

static void the_target_is_in_focus_unless_said(void** state) {
    (void)state;
    ty_camera_def def = odd_camera();
    def.aperture_radius = 0.1;
    assert_close(ty_camera_get_view(&def, 4, 4).per_focus, 1 / sqrt(4 + 2.25 + 25), 1e-6);
}

static void motion_begins_and_ends_with_its_poses(void** state) {
    (void)state;
    ty_camera_def def = odd_camera(), end = def;
    def.moves = 1;
    set3(def.end_position, 2, 2, 2);
    set3(def.end_target, 0, 1, -3);
    set3(def.end_up, 0, 1, 0);
    set3(end.position, 2, 2, 2);
    set3(end.target, 0, 1, -3);
    set3(end.up, 0, 1, 0);
    const ty_camera_view moving = ty_camera_get_view(&def, 40, 20), closed = ty_camera_get_view(&end, 40, 20);
    const ty_camera_view first = ty_camera_sample(&moving, 0.3f, 0.7f, 0),
                         last = ty_camera_sample(&moving, 0.3f, 0.7f, 1);
    assert_same_direction(ty_camera_direction(&first, 9, 2), ty_camera_direction(&moving, 9, 2));
    assert_same_direction(ty_camera_direction(&last, 9, 2), ty_camera_direction(&closed, 9, 2));
    assert_close(length_of(ty_sub(last.origin, closed.origin)), 0, 1e-6);
}

/* ---- images ---- */

enum { SIDE = 33 };

/* A small glowing quad on the axis at z = -5, seen from z = 5. */
static ty_scene* spark(ty_context* context, double aperture) {
    const double corners[3][3] = {{-0.15, -0.15, -5}, {0.3, 0, 0}, {0, 0.3, 0}};
    ty_scene* scene = make_scene(context);
    ty_shape_def quad = quad_shape(corners);
    set3f(quad.emission, 1, 1, 1);
    ty_camera_def camera = ty_default_camera_def();
    camera.fov_y = 20;
    camera.aperture_radius = aperture;
    assert_int_equal(ty_scene_add_shape(scene, &quad), TY_OK);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* Sum of green, and its mean square distance from the centre, pixels^2. */
static void moments_of(ty_context* context, double aperture, double* sum, double* spread) {
    ty_scene* scene = spark(context, aperture);
    ty_path_def def = ty_default_path_def();
    ty_image* image = NULL;
    const float* planes[3];
    def.width = def.height = SIDE;
    def.spp = 1024;
    assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_OK);
    assert_true(ty_image_rgb_planes(image, planes));
    *sum = *spread = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const double x = i % SIDE - SIDE / 2, y = i / SIDE - SIDE / 2;
        *sum += (double)planes[1][i];
        *spread += (double)planes[1][i] * (x * x + y * y);
    }
    *spread /= *sum;
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* A point at distance D blurs to a disk of radius r |1 / F - 1 / D| over the pixels' angle (thin lens), whose mean
 * square radius is half the square of that. Measured: sum within 0.4 %, spread within 2 %,
 * of which 1.2 % is the width of pixels. */
static void light_out_of_focus_is_spread_over_a_disk(void** state) {
    double sharp[2], blurred[2];
    moments_of(*state, 0, &sharp[0], &sharp[1]);
    moments_of(*state, 0.6, &blurred[0], &blurred[1]);
    const double pixel = 2 * tan(10 * 3.14159265358979 / 180) / SIDE;
    const double radius = 0.6 * (1.0 / 5 - 1.0 / 10) / pixel;
    assert_close(blurred[0] / sharp[0], 1, 0.03);
    assert_close(blurred[1] - sharp[1], radius * radius / 2, 0.05 * radius * radius / 2);
}

static double mean_of(const ty_image* image) {
    const float* planes[3];
    double sum = 0;
    assert_true(ty_image_rgb_planes(image, planes));
    const int32_t count = ty_image_width(image) * ty_image_height(image);
    for (int32_t i = 0; i < count; ++i) sum += (double)planes[1][i];
    return sum / count;
}

/* The same absorbing fog before a sky, whose image needs no scattering. Measured: means alike
 * within 0.1 %. */
static void the_marcher_shows_lens_and_motion_as_path_does(void** state) {
    ty_scene* scene = dark_scene(*state);
    ty_camera_def camera = ty_default_camera_def();
    camera.aperture_radius = 0.5;
    camera.focus_distance = 9;
    camera.moves = 1;
    set3(camera.end_position, 0.4, 0, 5);
    set3(camera.end_target, 0.4, 0, 0);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    ty_path_def path = ty_default_path_def();
    ty_dom_def dom = ty_default_dom_def();
    ty_image *truth = NULL, *image = NULL;
    path.width = dom.width = WIDTH;
    path.height = dom.height = HEIGHT;
    path.spp = 512;
    assert_int_equal(ty_path_render(scene, &path, &truth, NULL), TY_OK);
    assert_int_equal(ty_dom_render(scene, &dom, &image, NULL), TY_OK);
    assert_close(mean_of(image) / mean_of(truth), 1, 0.005);
    const float *a[3], *b[3];
    assert_true(ty_image_rgb_planes(image, a) && ty_image_rgb_planes(truth, b));
    for (int i = 0; i < PIXELS; ++i) assert_close(a[1][i], b[1][i], 0.06);
    ty_image_destroy(image);
    ty_image_destroy(truth);
    ty_scene_destroy(scene);
}

static void methods_of_one_eye_refuse_lenses(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_camera_def camera = ty_default_camera_def();
    camera.aperture_radius = 0.1;
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    ty_lpv_def lpv = ty_default_lpv_def();
    ty_image* image = NULL;
    lpv.width = WIDTH;
    lpv.height = HEIGHT;
    assert_int_equal(ty_lpv_render(scene, &lpv, &image, NULL), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(*state), "lpv: the camera has an aperture or moves"));
    ty_screen_def screen = ty_default_screen_def();
    assert_int_equal(ty_screen_set_scene(scene, 0, &screen), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(*state), "screen: the camera has an aperture or moves"));
    ty_scene_destroy(scene);
}

/* ---- media that hardly absorb but emit ---- */

/* A grid of a clear flame: optical thickness 0.001, radiance through it near 0.001 times 1000. Measured:
 * 3.7 % of noise with 64 samples. */
static void clear_flames_have_little_noise(void** state) {
    const float values[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    ty_grid* grid = NULL;
    ty_grid_def data = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) data.size[a] = 2;
    data.values = values;
    assert_int_equal(ty_grid_create(*state, &data, &grid), TY_OK);
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_medium_def flame = box_medium(lower, upper, 0, 0.0005f);
    flame.density_grid = grid;
    set3f(flame.emission, 1000, 1000, 1000);
    ty_scene* scene = make_scene(*state);
    assert_int_equal(ty_scene_add_medium(scene, &flame), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    double ray[6] = {0, 0, 5, 0, 0, 1}, radiance[3];
    double sum = 0, squares = 0;
    for (uint64_t seed = 0; seed < 16; ++seed) {
        ty_path_def def = ty_default_path_def();
        def.spp = 64;
        def.seed = seed;
        assert_int_equal(ty_path_radiance(scene, &def, ray, 1, radiance, NULL), TY_OK);
        sum += radiance[1] / 16;
        squares += radiance[1] * radiance[1] / 16;
    }
    assert_close(sum, 1000 * (1 - exp(-0.001)), 0.05);
    assert_true(sqrt(squares - sum * sum) < 0.1 * sum);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shift_is_a_fraction_of_the_height),
        cmocka_unit_test(all_points_of_a_lens_see_the_plane_in_focus_alike),
        cmocka_unit_test(the_target_is_in_focus_unless_said),
        cmocka_unit_test(motion_begins_and_ends_with_its_poses),
        cmocka_unit_test(light_out_of_focus_is_spread_over_a_disk),
        cmocka_unit_test(the_marcher_shows_lens_and_motion_as_path_does),
        cmocka_unit_test(methods_of_one_eye_refuse_lenses),
        cmocka_unit_test(clear_flames_have_little_noise),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
