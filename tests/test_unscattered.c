/* Light that no medium scattered or sent: closed forms, and what it must have in common with other renders. */
#include "fog.h"

static const double pi = 3.14159265358979323846;
static const double sigma_t[3] = {0.05, 0.1, 0.3};

/* Chromatic fog over 3 m before the camera at (0, 0, 5); it scatters, absorbs and glows. */
static void add_fog(ty_scene* scene) {
    const double lower[3] = {-20, -20, -1}, upper[3] = {20, 20, 2};
    ty_medium_def fog = box_medium(lower, upper, 0, 0);
    for (int c = 0; c < 3; ++c) {
        fog.sigma_s[c] = (float)(0.7 * sigma_t[c]);
        fog.sigma_a[c] = (float)(0.3 * sigma_t[c]);
        fog.emission[c] = 2;
    }
    fog.g[0] = fog.g[1] = fog.g[2] = 0.5f;
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
}

static ty_path_def unscattered_def(int32_t spp) {
    ty_path_def def = small_def(spp);
    def.unscattered = true;
    return def;
}

static void assert_radiance(const ty_scene* scene, const double ray[6], const double expected[3]) {
    const ty_path_def def = unscattered_def(4);
    double radiance[3], variance[3];
    assert_int_equal(ty_path_radiance(scene, &def, ray, 1, radiance, variance), TY_OK);
    for (int c = 0; c < 3; ++c) {
        assert_close(radiance[c], expected[c], 2e-6 * expected[c]);
        assert_close(variance[c], 0, 1e-12);
    }
}

static void what_shines_is_seen_through_fog(void** state) {
    static const double ray[6] = {0, 0, 5, 0, 0, 2}, past[6] = {3, 0, 5, 0, 0, 2};
    ty_scene* scene = make_scene(*state);
    ty_light_def sky = sky_light(0.25f, 0.5f, 0.75f);
    ty_shape_def board = quad_shape((const double[3][3]){{-1, -1, -3}, {2, 0, 0}, {0, 2, 0}});
    set3f(board.emission, 3, 2, 1);
    set3f(board.albedo, 0, 0, 0);
    add_fog(scene);
    assert_int_equal(ty_scene_add_shape(scene, &board), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    double seen[3], beside[3];
    for (int c = 0; c < 3; ++c) {
        seen[c] = (double)board.emission[c] * exp(-3 * sigma_t[c]);
        beside[c] = (double)sky.color[c] * exp(-3 * sigma_t[c]);
    }
    assert_radiance(scene, ray, seen);
    assert_radiance(scene, past, beside);
    ty_scene_destroy(scene);
}

/* A wall behind the fog under a slanting sun, which comes through the fog, too; and the fluence behind both. */
static void surfaces_reflect_what_fog_lets_pass(void** state) {
    static const double ray[6] = {0.3, 0.2, 5, 0, 0, 1}, point[3] = {0, 0, -2};
    static const int32_t size[3] = {1, 1, 1};
    ty_scene* scene = make_scene(*state);
    ty_light_def sun = ty_default_light_def();
    set3(sun.direction, 0.6, 0, -0.8);
    set3f(sun.color, 2, 2, 2);
    ty_shape_def wall = quad_shape((const double[3][3]){{-10, -10, -3}, {20, 0, 0}, {0, 20, 0}});
    set3f(wall.albedo, 0.8f, 0.5f, 0.2f);
    add_fog(scene);
    assert_int_equal(ty_scene_add_shape(scene, &wall), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    double expected[3], fluence[3], uncollided[3];
    for (int c = 0; c < 3; ++c) {
        const double sunlight = 2 * exp(-3 / 0.8 * sigma_t[c]);
        expected[c] = (double)wall.albedo[c] / pi * 0.8 * sunlight * exp(-3 * sigma_t[c]);
    }
    assert_radiance(scene, ray, expected);
    const ty_path_def def = unscattered_def(64);
    assert_int_equal(ty_path_fluence(scene, &def, point, point, size, fluence, uncollided, NULL), TY_OK);
    for (int c = 0; c < 3; ++c) {
        const double sunlight = 2 * exp(-3 / 0.8 * sigma_t[c]);
        assert_close(uncollided[c], sunlight, 2e-6 * sunlight);
        assert_true(fluence[c] > sunlight * (1 + 0.1 * (double)wall.albedo[c]));
    }
    ty_scene_destroy(scene);
}

/* Fog that only absorbs and sends nothing leaves all light unscattered: a grid's estimates need no more than agree. */
static void absorbing_fog_is_no_other_case(void** state) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_noise_def noise = ty_default_noise_def();
    noise.size[0] = noise.size[1] = noise.size[2] = 16;
    ty_scene* scene = make_scene(*state);
    ty_medium_def fog = box_medium(lower, upper, 0, 1);
    assert_int_equal(ty_grid_create_noise(*state, &noise, &fog.density_grid), TY_OK);
    ty_light_def sky = sky_light(1, 1, 1);
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    ball.radius = 0.4;
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_path_def plain = small_def(256), unscattered = unscattered_def(256);
    ty_image *expected = render(scene, &plain, NULL), *image = render(scene, &unscattered, NULL);
    for (int c = 0; c < 3; ++c) {
        const double error = sqrt(total(image, 3 + c) + total(expected, 3 + c));
        assert_true(error < 0.01 * total(expected, c));
        assert_close(total(image, c), total(expected, c), 4 * error);
    }
    ty_image_destroy(expected);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    ty_grid_release(fog.density_grid);
}

/* Where there are no media, or none count, nothing is another, to the last bit; where there are, scattered light is
 * missing and no channel holds any. */
static void only_media_make_a_difference(void** state) {
    ty_scene *foggy = foggy_scene(*state), *clear = lit_scene(*state, false);
    ty_path_def plain = small_def(4), unscattered = unscattered_def(4), ignoring = plain, both = unscattered;
    ignoring.ignore_media = both.ignore_media = true;
    unscattered.aovs |= TY_AOV_SINGLE | TY_AOV_MULTIPLE;
    plain.aovs = unscattered.aovs;
    ty_image* const images[] = {render(clear, &plain, NULL),    render(clear, &unscattered, NULL),
                                render(foggy, &ignoring, NULL), render(foggy, &both, NULL),
                                render(foggy, &plain, NULL),    render(foggy, &unscattered, NULL)};
    assert_true(same_images(images[0], images[1]));
    assert_true(same_images(images[2], images[3]));
    for (int c = 0; c < 3; ++c) {
        assert_true(total(images[5], c) < 0.95 * total(images[4], c));
        assert_true(total(images[4], 6 + c) > 0 && total(images[5], 6 + c) == 0);
        assert_true(total(images[4], 9 + c) > 0 && total(images[5], 9 + c) == 0);
    }
    for (int i = 0; i < 6; ++i) ty_image_destroy(images[i]);
    ty_scene_destroy(foggy);
    ty_scene_destroy(clear);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_shines_is_seen_through_fog),
        cmocka_unit_test(surfaces_reflect_what_fog_lets_pass),
        cmocka_unit_test(absorbing_fog_is_no_other_case),
        cmocka_unit_test(only_media_make_a_difference),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
