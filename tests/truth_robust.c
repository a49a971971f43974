/* The same bits whatever the number of threads, other noise for other seeds, and finite numbers in nasty scenes. */
#define _GNU_SOURCE
#include "truth.h"

#include <unistd.h>

/* A drop of paint beside haze, g near its ends, a camera in the middle of it, boards seen edge on, lights within
 * media, a glowing ball in fog. */
static ty_scene* nasty_scene(ty_context* context) {
    ty_scene* scene = new_scene(context);
    ty_medium_def haze = medium_cube(10, 1e-4, 1e-5, 0.99), paint = medium_sphere(0.02, 1e4, 1, -0.99);
    set3(paint.sphere_center, 0.3, 0.1, -1.5);
    add_medium(scene, &haze);
    add_medium(scene, &paint);
    ty_medium_def fog = medium_cube(3, 0.5, 0, 0.99);
    rgb(fog.sigma_a, 0, 10, 100);
    rgb(fog.g, 0.99, 0, -0.99);
    add_medium(scene, &fog);
    ty_medium_def cloud = medium_cube(2, 50, 0, 0.9);
    ty_noise_def noise = ty_default_noise_def();
    noise.size[0] = noise.size[1] = noise.size[2] = 24;
    must(context, ty_grid_create_noise(context, &noise, &cloud.density_grid));
    rgb(cloud.sigma_s, 0.01, 1, 50);
    add_medium(scene, &cloud);
    ty_grid_release(cloud.density_grid);
    static const double center[3] = {0, -1e-4, -2}, x[3] = {1, 0, 0}, z[3] = {0, 0, 1}, slant[3] = {0, 1e-3, 1};
    ty_shape_def floor_board = square_shape(center, z, x, 2, 1), ramp = square_shape(center, slant, x, 2, 0.9);
    const ty_shape_def ball = sphere_shape(-0.5, 0.2, -2, 0.3, 1, 50), speck = sphere_shape(0.2, 0, -1, 1e-4, 1, 1e6);
    add_shape(scene, &floor_board);
    add_shape(scene, &ramp);
    add_shape(scene, &ball);
    add_shape(scene, &speck);
    ty_light_def lamp = light_of(TY_LIGHT_POINT, 1e-2), beam = light_of(TY_LIGHT_SPOT, 1),
                 sun = light_of(TY_LIGHT_DIRECTIONAL, 3);
    set3(lamp.position, 0, 0, -1);
    beam.cone = 1;
    set3(beam.position, 1, 1, -2);
    set3(sun.direction, 1, 0, 0); /* along the boards */
    add_light(scene, &lamp);
    add_light(scene, &beam);
    add_light(scene, &sun);
    ty_light_def panel = light_of(TY_LIGHT_AREA, 10), black = light_of(TY_LIGHT_POINT, 0);
    set3(panel.position, -1, 0, -3); /* touches the floor */
    set3(panel.u, 1, 0, 0);
    set3(panel.v, 0, 1e-6, 0);
    add_light(scene, &panel);
    add_light(scene, &black);
    const ty_light_def sky = light_of(TY_LIGHT_ENVIRONMENT, 1e-3);
    add_light(scene, &sky);
    set_camera(scene, 0, 0, 0.5, 90);
    commit(scene);
    return scene;
}

static void threads_do_not_matter(void** state) {
    (void)state;
    enum { W = 50, RAYS = 200, CELLS = 64 };
    static float pixels[6][W * W], first_pixels[6][W * W];
    static double rays[6 * RAYS], radiance[3 * RAYS], first_radiance[3 * RAYS], fluence[3 * CELLS],
        first_fluence[3 * CELLS];
    for (int i = 0; i < RAYS; ++i) {
        double x[4];
        even_point(i, x);
        set3(rays + 6 * i, x[0] - 0.5, x[1] - 0.5, 1);
        set3(rays + 6 * i + 3, x[2] - 0.5, x[3] - 0.5, -1);
    }
    for (int32_t threads = 1; threads <= 3; ++threads) {
        ty_context* context = truth_context(threads);
        ty_scene* scene = nasty_scene(context);
        ty_image* image = render(scene, W, 19, 5);
        radiance_along(scene, RAYS, rays, 19, 0, radiance, NULL);
        static const double lower[3] = {-1, -1, -4}, upper[3] = {1, 1, -1};
        static const int32_t size[3] = {4, 4, 4};
        ty_path_def def = ty_default_path_def();
        def.spp = 19;
        must(context, ty_path_fluence(scene, &def, lower, upper, size, fluence, NULL, NULL));
        for (int c = 0; c < 6; ++c) memcpy(pixels[c], ty_image_plane_const(image, c), sizeof pixels[c]);
        if (threads == 1) {
            memcpy(first_pixels, pixels, sizeof pixels);
            memcpy(first_radiance, radiance, sizeof radiance);
            memcpy(first_fluence, fluence, sizeof fluence);
        }
        assert_memory_equal(first_pixels, pixels, sizeof pixels);
        assert_memory_equal(first_radiance, radiance, sizeof radiance);
        assert_memory_equal(first_fluence, fluence, sizeof fluence);
        ty_image_destroy(image);
        ty_scene_destroy(scene);
        ty_context_destroy(context);
    }
}

static void seeds_matter(void** state) {
    ty_scene* scene = new_scene(*state);
    const ty_medium_def fog = medium_sphere(1.5, 2, 0.1, 0.3);
    const ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    add_medium(scene, &fog);
    add_light(scene, &sun);
    set_camera(scene, 0, 0, 5, 20);
    commit(scene);
    ty_image *a = render(scene, 32, 4, 1), *again = render(scene, 32, 4, 1), *b = render(scene, 32, 4, 2);
    int same = 0;
    for (int i = 0; i < 32 * 32; ++i) same += ty_image_plane_const(a, 0)[i] == ty_image_plane_const(b, 0)[i];
    assert_memory_equal(ty_image_plane_const(a, 0), ty_image_plane_const(again, 0), 32 * 32 * sizeof(float));
    assert_true(same < 32 * 32 / 100);
    ty_image_destroy(a);
    ty_image_destroy(again);
    ty_image_destroy(b);
    ty_scene_destroy(scene);
}

static void assert_finite_numbers(const double* values, int count) {
    for (int i = 0; i < count; ++i)
        if (!isfinite(values[i]) || values[i] < 0) fail_msg("number %d is %g", i, values[i]);
}

static void images_are_always_finite(void** state) {
    ty_scene* scene = nasty_scene(*state);
    for (uint64_t seed = 0; seed < (in_full() ? 3 : 1); ++seed) {
        ty_image* image = render(scene, 64, 16, seed);
        assert_finite(image);
        ty_image_destroy(image);
    }
    /* Rays that begin on lights, boards, corners and faces of media, and graze them. */
    static const double starts[7][3] = {{0, 0, -1},    {0, -1e-4, -2},   {-0.5, 0.2, -2},  {2, 2, 2},
                                        {2, -1e-4, 0}, {0.3, 0.1, -1.5}, {0.32, 0.1, -1.5}};
    enum { WAYS = 64 };
    static double rays[7 * WAYS * 6], radiance[7 * WAYS * 3], variance[7 * WAYS * 3];
    for (int s = 0; s < 7; ++s)
        for (int w = 0; w < WAYS; ++w) {
            double x[4];
            even_point(w, x);
            double* ray = rays + 6 * (s * WAYS + w);
            memcpy(ray, starts[s], sizeof starts[s]);
            /* Some along the axes, exactly. */
            if (w < 6)
                set3(ray + 3, (w == 0) - (w == 1), (w == 2) - (w == 3), (w == 4) - (w == 5));
            else
                set3(ray + 3, x[0] - 0.5, w % 2 ? 0 : x[1] - 0.5, x[2] - 0.5);
        }
    radiance_along(scene, 7 * WAYS, rays, fewer(64, 4), 0, radiance, variance);
    assert_finite_numbers(radiance, 7 * WAYS * 3);
    assert_finite_numbers(variance, 7 * WAYS * 3);
    /* Fluence where the lamp is. */
    static const int32_t size[3] = {64, 1, 1};
    double fluence[64 * 3];
    ty_path_def def = ty_default_path_def();
    must(*state, ty_path_fluence(scene, &def, starts[0], starts[0], size, fluence, NULL, NULL));
    assert_finite_numbers(fluence, 64 * 3);
    ty_scene_destroy(scene);
}

static void nothing_is_black(void** state) {
    ty_scene* scene = new_scene(*state);
    set_camera(scene, 0, 0, 5, 40);
    commit(scene);
    ty_image* image = render(scene, 8, 4, 1);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 64; ++i) assert_true(ty_image_plane_const(image, c)[i] == 0);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* A closed room that absorbs nothing, in thin smoke that does not scatter: paths are ended all the same. */
static void white_rooms_come_to_an_end(void** state) {
    ty_scene* scene = new_scene(*state);
    ty_medium_def smoke = medium_cube(1.1, 0, 1e-9, 0);
    ty_noise_def noise = ty_default_noise_def();
    noise.size[0] = noise.size[1] = noise.size[2] = 16;
    must(*state, ty_grid_create_noise(*state, &noise, &smoke.density_grid));
    add_medium(scene, &smoke);
    ty_grid_release(smoke.density_grid);
    ty_shape_def room = ty_default_shape_def();
    room.kind = TY_SHAPE_BOX;
    set3(room.origin, -1, -1, -1);
    set3(room.u, 1, 1, 1);
    gray(room.albedo, 1);
    add_shape(scene, &room);
    ty_light_def lamp = light_of(TY_LIGHT_POINT, 1);
    set3(lamp.position, 0.7, 0.7, 0.7);
    add_light(scene, &lamp);
    set_camera(scene, 0, 0, 0.9, 60);
    commit(scene);
    alarm(60); /* rather than for ever */
    ty_image* image = render(scene, 8, 1, 1);
    alarm(0);
    assert_finite(image);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_matter),      cmocka_unit_test(seeds_matter),
        cmocka_unit_test(images_are_always_finite),   cmocka_unit_test(nothing_is_black),
        cmocka_unit_test(white_rooms_come_to_an_end),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
