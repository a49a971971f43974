/* Light of area lights, emissive surfaces, environments and glowing media by method lpv, against closed forms. */
#include "direct_maker.h"

#include <tyndall/lpv.h>

#include <math.h>
#include <stdio.h>

enum { WIDTH = 24, HEIGHT = 16 };

static const double pi = 3.14159265358979323846;

/* ---- scenes ---- */

static void look(ty_scene* scene, double x, double y, double z, double tx, double ty, double tz) {
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, x, y, z);
    set3(camera.target, tx, ty, tz);
    camera.fov_y = 20;
    camera.resolution[0] = WIDTH;
    camera.resolution[1] = HEIGHT;
    check_result(ty_scene_context(scene), ty_scene_set_camera(scene, &camera));
}

static void add_ball(ty_scene* scene, double x, double y, double z, double radius, float albedo, float emission) {
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    set3(ball.origin, x, y, z);
    ball.radius = radius;
    set3f(ball.albedo, albedo, albedo, albedo);
    set3f(ball.emission, emission, 2 * emission, 3 * emission);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &ball));
}

static void add_floor(ty_scene* scene, double half, float albedo) {
    ty_shape_def floor = quad_shape((const double[3][3]){{-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half}});
    set3f(floor.albedo, albedo, albedo, albedo);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &floor));
}

static ty_lpv_def small_def(void) {
    ty_lpv_def def = ty_default_lpv_def();
    def.resolution = 12;
    def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE;
    return def;
}

static ty_image* image_of(ty_scene* scene, const ty_lpv_def* def, ty_lpv_stats* stats) {
    ty_image* image = NULL;
    check_result(ty_scene_context(scene), ty_scene_commit(scene));
    check_result(ty_scene_context(scene), ty_lpv_render(scene, def, &image, stats));
    return image;
}

static double mean_of(const ty_image* image, const char* name) {
    const int32_t channel = ty_image_find_channel(image, name);
    assert_true(channel >= 0);
    double sum = 0;
    for (int i = 0; i < WIDTH * HEIGHT; ++i) sum += (double)ty_image_plane_const(image, channel)[i];
    return sum / (WIDTH * HEIGHT);
}

static double pixel_of(const ty_image* image, const char* name, int x, int y) {
    const int32_t channel = ty_image_find_channel(image, name);
    assert_true(channel >= 0);
    return (double)ty_image_plane_const(image, channel)[y * WIDTH + x];
}

/* ---- surfaces ---- */

/* A floor under an even sky of radiance L reflects albedo L of direct light: its irradiance is pi L. */
static void skies_light_floors(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_lpv_def def = small_def();
    def.parts = 0;
    def.light_samples = 32;
    const ty_light_def sky = sky_light(1, 2, 3);
    look(scene, 0, 4, 4, 0, 0, 0);
    add_floor(scene, 5, 0.5f);
    check_result(*state, ty_scene_add_light(scene, &sky));
    ty_image* image = image_of(scene, &def, NULL);
    /* Measured: 0.4992, 0.9984. */
    assert_close(mean_of(image, "R"), 0.5, 0.002);
    assert_close(mean_of(image, "G"), 1.0, 0.004);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* The irradiance below a ball of radiance L and radius r in the distance d is pi L r^2 / d^2. */
static void balls_light_floors(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_lpv_def def = small_def();
    def.parts = 0;
    look(scene, 0, 0.5, 1.5, 0, 0, 0);
    add_floor(scene, 5, 0.5f);
    add_ball(scene, 0, 3, 0, 0.5, 0, 8);
    ty_image* image = image_of(scene, &def, NULL);
    const double expected = 0.5 * 8 * 0.25 / 9; /* albedo / pi times that */
    /* Measured: 0.1108, expected 0.1111; the middle of the picture is the point below the ball. */
    assert_close(pixel_of(image, "R", WIDTH / 2, HEIGHT / 2), expected, 0.02 * expected);
    assert_close(pixel_of(image, "B", WIDTH / 2, HEIGHT / 2), 3 * expected, 0.06 * expected);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

static void add_room(ty_scene* scene) {
    ty_shape_def room = ty_default_shape_def();
    room.kind = TY_SHAPE_BOX;
    set3(room.origin, -2, -2, -2);
    set3(room.u, 2, 2, 2);
    set3f(room.albedo, 0.5f, 0.5f, 0.5f);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &room));
}

/* In a closed room all of a ball's power, pi L times its surface, meets the walls, which reflect half of it first. */
static void rooms_reflect_what_is_emitted(void** state) {
    ty_scene* scene = make_scene(*state);
    const ty_lpv_def def = small_def();
    ty_lpv_stats stats = ty_default_lpv_stats();
    add_room(scene);
    look(scene, 0, 0, 1.9, 0, 0, 0);
    add_ball(scene, 0.3, 0.4, 0.2, 0.5, 0, 1);
    ty_image_destroy(image_of(scene, &def, &stats));
    const double power = pi * 4 * pi * 0.25;
    /* Measured: 0.503 of the power. */
    assert_close(stats.reflected[0], 0.5 * power, 0.02 * power);
    assert_close(stats.reflected[2], 1.5 * power, 0.06 * power);
    ty_scene_destroy(scene);
}

/* A sealed room stays dark under a bright sky. */
static void walls_keep_skies_out(void** state) {
    ty_scene* scene = make_scene(*state);
    const ty_lpv_def def = small_def();
    const ty_light_def sky = sky_light(100, 100, 100);
    const double lower[3] = {-3, -3, -3}, upper[3] = {3, 3, 3};
    const ty_medium_def fog = box_medium(lower, upper, 0.3f, 0.01f);
    add_room(scene);
    check_result(*state, ty_scene_add_light(scene, &sky));
    check_result(*state, ty_scene_add_medium(scene, &fog));
    look(scene, 0, 0, 1.5, 0, 0, 0);
    ty_image* image = image_of(scene, &def, NULL);
    /* Measured: 0. */
    assert_true(mean_of(image, "R") < 0.01);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* ---- media ---- */

/* The white furnace: fog that absorbs nothing, inside an even sky, is invisible. */
static void fog_is_invisible_in_an_even_sky(void** state) {
    static const float depths[3] = {0.1f, 0.5f, 2.0f};
    static const double measured[3] = {1.0004, 0.9943, 1.0014};
    for (int i = 0; i < 3; ++i) {
        const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
        ty_scene* scene = make_scene(*state);
        const ty_lpv_def def = small_def();
        const ty_light_def sky = sky_light(1, 1, 1);
        ty_medium_def fog = box_medium(lower, upper, depths[i], 0);
        fog.g[0] = fog.g[1] = fog.g[2] = 0.4f;
        check_result(*state, ty_scene_add_medium(scene, &fog));
        check_result(*state, ty_scene_add_light(scene, &sky));
        look(scene, 0, 0, 4, 0, 0, 0);
        ty_image* image = image_of(scene, &def, NULL);
        printf("furnace of %.1f/m: %.4f, single %.4f, multiple %.4f\n", (double)depths[i], mean_of(image, "R"),
               mean_of(image, "single.R"), mean_of(image, "multiple.R"));
        assert_close(mean_of(image, "R"), measured[i], 0.01);
        assert_true(mean_of(image, "single.R") > 0.1 && mean_of(image, "multiple.R") > 0);
        ty_image_destroy(image);
        ty_scene_destroy(scene);
    }
}

/* Cells larger than the mean free path, half of them beyond the medium: what scatters is what enters, pi L times the
 * surface that the sky sees. Without the attenuation within cells it is 12 times that. */
static void dense_media_scatter_what_enters(void** state) {
    const double lower[3] = {-2, 0, -2}, upper[3] = {2, 1, 2};
    ty_scene* scene = make_scene(*state);
    const ty_lpv_def def = small_def();
    ty_lpv_stats stats = ty_default_lpv_stats();
    const ty_light_def sky = sky_light(1, 1, 1);
    const ty_medium_def smoke = box_medium(lower, upper, 60, 0);
    check_result(*state, ty_scene_add_medium(scene, &smoke));
    check_result(*state, ty_scene_add_light(scene, &sky));
    add_floor(scene, 4, 0);
    look(scene, 0, 12, 0.1, 0, 0, 0);
    ty_image* image = image_of(scene, &def, &stats);
    const double entering = pi * (4 * 4 + 4 * 4 * 1);
    printf("scattered %.3f of the light that enters\n", stats.scattered[0] / entering);
    assert_true(stats.scattered[0] > 0.3 * entering && stats.scattered[0] <= entering);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* Thin fog of g = 0.9 seen at a right angle to the light of a far ball: sigma_s d E HG(0, 0.9). Five bands of the
 * ball's radiance would have 15 times as much. */
static void narrow_lobes_are_dark_beside(void** state) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(*state);
    const ty_lpv_def def = small_def();
    ty_medium_def fog = box_medium(lower, upper, 0.01f, 0);
    fog.g[0] = fog.g[1] = fog.g[2] = 0.9f;
    check_result(*state, ty_scene_add_medium(scene, &fog));
    add_ball(scene, 0, 12, 0, 0.3, 0, 1000);
    look(scene, 0, 0, 8, 0, 0, 0);
    ty_image* image = image_of(scene, &def, NULL);
    const double irradiance = pi * 1000 * pow(0.3 / 12, 2), phase = (1 - 0.81) / (4 * pi * pow(1 + 0.81, 1.5));
    const double single = pixel_of(image, "single.R", WIDTH / 2, HEIGHT / 2), right = 0.01 * 2 * irradiance * phase;
    printf("side of a narrow lobe: %.3f of single scattering\n", single / right);
    assert_close(single / right, 1, 0.1);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* A glowing medium injects 4 pi sigma_a L of each unit of volume, and lights the floor below it. */
static void glowing_media_light_floors(void** state) {
    const double lower[3] = {-1, 1, -1}, upper[3] = {1, 3, 1};
    ty_scene* scene = make_scene(*state);
    const ty_lpv_def def = small_def();
    ty_lpv_stats stats = ty_default_lpv_stats();
    ty_medium_def fire = box_medium(lower, upper, 0, 0.1f);
    set3f(fire.emission, 2, 1, 0.5f);
    check_result(*state, ty_scene_add_medium(scene, &fire));
    add_floor(scene, 4, 0.5f);
    look(scene, 0, 12, 0.1, 0, 0, 0);
    ty_image* image = image_of(scene, &def, &stats);
    const double power = 4 * pi * 0.1 * 2 * 8;
    /* Measured: 1.002 of it; the lattice is a thousandth wider than the medium. */
    assert_close(stats.emitted[0], power, 5e-3 * power);
    assert_close(stats.emitted[1], 0.5 * power, 5e-3 * power);
    assert_true(pixel_of(image, "R", 2, HEIGHT / 2) > 0.002);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* ---- calls ---- */

static ty_scene* mixed_scene(ty_context* context) {
    const double lower[3] = {-2, 0, -2}, upper[3] = {2, 3, 2};
    ty_scene* scene = make_scene(context);
    const ty_medium_def fog = box_medium(lower, upper, 0.3f, 0.02f);
    ty_light_def area = ty_default_light_def(), lamp = area;
    const ty_light_def sky = sky_light(0.5f, 0.6f, 0.7f);
    area.kind = TY_LIGHT_AREA;
    set3(area.position, -0.5, 2.5, -0.5);
    set3(area.u, 1, 0, 0);
    set3(area.v, 0, 0, 1);
    set3f(area.color, 5, 4, 3);
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 1, 1, 1);
    check_result(context, ty_scene_add_medium(scene, &fog));
    check_result(context, ty_scene_add_light(scene, &area));
    check_result(context, ty_scene_add_light(scene, &sky));
    check_result(context, ty_scene_add_light(scene, &lamp));
    add_floor(scene, 2, 0.6f);
    add_ball(scene, 0.5, 0.5, 0, 0.3, 0.4f, 0.5f);
    look(scene, 0, 2, 6, 0, 1, 0);
    return scene;
}

static void results_do_not_depend_on_threads(void** state) {
    (void)state;
    ty_context* contexts[2] = {make_context(1), make_context(3)};
    ty_image* images[2];
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = mixed_scene(contexts[i]);
        ty_lpv_def def = small_def();
        def.cascades = 2;
        def.spp = 2;
        images[i] = image_of(scene, &def, NULL);
        ty_scene_destroy(scene);
    }
    for (int32_t c = 0; c < ty_image_channel_count(images[0]); ++c)
        assert_memory_equal(ty_image_plane_const(images[0], c), ty_image_plane_const(images[1], c),
                            WIDTH * HEIGHT * sizeof(float));
    for (int i = 0; i < 2; ++i) {
        ty_image_destroy(images[i]);
        ty_context_destroy(contexts[i]);
    }
}

/* Of a caller's maps, those of area lights and environments are not read; that of the lamp is. */
static void maps_of_extended_lights_are_not_read(void** state) {
    ty_scene* scene = mixed_scene(*state);
    const ty_rsm maps[3] = {{.side = 0}};
    ty_lpv_def def = small_def();
    ty_image* image = NULL;
    def.maps = maps;
    def.map_count = 3;
    check_result(*state, ty_scene_commit(scene));
    assert_int_equal(ty_lpv_render(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(*state), "maps[2]"));
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(skies_light_floors),
        cmocka_unit_test(balls_light_floors),
        cmocka_unit_test(rooms_reflect_what_is_emitted),
        cmocka_unit_test(walls_keep_skies_out),
        cmocka_unit_test(fog_is_invisible_in_an_even_sky),
        cmocka_unit_test(dense_media_scatter_what_enters),
        cmocka_unit_test(narrow_lobes_are_dark_beside),
        cmocka_unit_test(glowing_media_light_floors),
        cmocka_unit_test(results_do_not_depend_on_threads),
        cmocka_unit_test(maps_of_extended_lights_are_not_read),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
