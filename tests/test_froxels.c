/* Images from froxels: closed forms, surfaces between slices, cameras within fog, refinement towards a ray per pixel,
 * and what is refused. */
#include "effort.h"
#include "files.h"
#include "fog.h"
#include "march_maker.h"

#include <tyndall/octaves.h>

static const double low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};

static void set_froxels(ty_march_def* def, int32_t columns, int32_t rows, int32_t slices) {
    def->froxels[0] = columns;
    def->froxels[1] = rows;
    def->froxels[2] = slices;
}

/* ---- transmittance ---- */

enum { WIDE = 40, HIGH = 30 };

/* Uniform fog around the origin with a slanted wall through it, seen by a camera at z. */
static ty_scene* walled_fog(ty_context* context, float sigma_a, double z) {
    ty_scene* scene = make_scene(context);
    const ty_medium_def fog = box_medium(low, high, 0, sigma_a);
    const ty_shape_def wall = quad_shape((const double[3][3]){{-3, -3, -1.5}, {6, 0, 0}, {0, 6, 2}});
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0.2, 0.1, z);
    set3(camera.target, 0, 0, -3);
    camera.fov_y = 50;
    check_result(context, ty_scene_add_medium(scene, &fog));
    check_result(context, ty_scene_add_shape(scene, &wall));
    check_result(context, ty_scene_set_camera(scene, &camera));
    check_result(context, ty_scene_commit(scene));
    return scene;
}

/* The largest difference of transmittance between froxels and a ray per pixel. */
static double transmittance_error(const ty_scene* scene, ty_march_def* def, int32_t slices) {
    double error = 0;
    ty_image* images[2];
    for (int i = 0; i < 2; ++i) {
        set_froxels(def, i * WIDE, i * HIGH, i * slices);
        images[i] = march_image(scene, def, NULL);
    }
    for (int i = 0; i < WIDE * HIGH; ++i)
        error = fmax(error,
                     fabs(march_value(images[0], "transmittance.G", i) - march_value(images[1], "transmittance.G", i)));
    assert_memory_equal(ty_image_plane_const(images[0], ty_image_find_channel(images[0], "depth.Z")),
                        ty_image_plane_const(images[1], ty_image_find_channel(images[1], "depth.Z")),
                        WIDE * HIGH * sizeof(float));
    ty_image_destroy(images[0]);
    ty_image_destroy(images[1]);
    return error;
}

/* With a column through each pixel's center, transmittance at a surface between two ends of slices is interpolated
 * linearly: it is off by at most (sigma dt)^2 / 8 within the fog, and by up to sigma dt / 4 in a slice where a ray
 * enters it. Bounds are measured ones and a fifth more. */
static void surfaces_between_slices(void** state) {
    static const double eyes[] = {4, 0.5}, bounds[2][3] = {{0.018, 0.0032, 1.4e-4}, {0.0025, 1.6e-4, 1e-5}};
    for (int e = 0; e < 2; ++e) {
        ty_scene* scene = walled_fog(*state, 1, eyes[e]);
        ty_march_def def = march_def(WIDE, HIGH);
        def.aovs = TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;
        for (int i = 0; i < 3; ++i) {
            const double error = transmittance_error(scene, &def, 8 << 2 * i);
            print_message("eye %g, %d slices: %.2g\n", eyes[e], 8 << 2 * i, error);
            assert_true(error <= bounds[e][i]);
        }
        ty_scene_destroy(scene);
    }
}

/* ---- light ---- */

/* Lumps of smoke before a wall, with a ball in them, in the sun. */
static ty_scene* sunny_smoke(ty_context* context) {
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(low, high, 3, 0.5f);
    ty_light_def sun = ty_default_light_def();
    ty_shape_def ball = ty_default_shape_def();
    ty_camera_def camera = ty_default_camera_def();
    const ty_shape_def wall = quad_shape((const double[3][3]){{-3, -3, -0.5}, {6, 0, 0}, {0, 6, 0.3}});
    set3f(medium.sigma_s, 2, 3, 4);
    medium.density_grid = lumpy_grid(context);
    set3(sun.direction, -1, -2, -0.5);
    ball.kind = TY_SHAPE_SPHERE;
    ball.radius = 0.3;
    set3(ball.origin, -0.4, 0.1, 0.4);
    set3(camera.position, 0.3, 0.2, 4);
    camera.fov_y = 30;
    check_result(context, ty_scene_add_medium(scene, &medium));
    ty_grid_release(medium.density_grid);
    check_result(context, ty_scene_add_light(scene, &sun));
    check_result(context, ty_scene_add_shape(scene, &wall));
    check_result(context, ty_scene_add_shape(scene, &ball));
    check_result(context, ty_scene_set_camera(scene, &camera));
    check_result(context, ty_scene_commit(scene));
    return scene;
}

static ty_octaves_def octaves_def(void) {
    ty_octaves_def def = ty_default_octaves_def();
    def.width = 2 * WIDE;
    def.height = 2 * HIGH;
    def.resolution = 16;
    def.count = 3;
    def.step = 0.25;
    def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE;
    return def;
}

static ty_image* octaves_image(const ty_octaves* light, const ty_scene* scene, const ty_octaves_def* def) {
    ty_image* image = NULL;
    check_result(ty_scene_context(scene), ty_octaves_view(light, scene, def, &image, NULL));
    return image;
}

/* Errors against a ray per pixel with steps of a quarter of a voxel fall with finer froxels: relative RMSE of pixels,
 * measured and a fifth more, and mean ratios. */
static void refinement_leads_to_the_march(void** state) {
    skip_under_sanitizers();
    static const double rmse[] = {0.34, 0.125, 0.038, 0.0017}, ratio[] = {0.01, 0.003, 0.002, 0.0005};
    ty_scene* scene = sunny_smoke(*state);
    ty_octaves_def def = octaves_def();
    ty_octaves* light = NULL;
    check_result(*state, ty_octaves_solve(scene, &def, &light, NULL));
    ty_image* marched = octaves_image(light, scene, &def);
    for (int i = 0; i < 4; ++i) {
        ty_difference difference;
        def.froxels = 10 << i;
        def.froxel_slices = 16 << i;
        ty_image* image = octaves_image(light, scene, &def);
        check_result(*state, ty_image_compare(*state, image, marched, 1, &difference));
        print_message("%d x %d froxels: %.4f / %.4f\n", (int)def.froxels, (int)def.froxel_slices,
                      difference.mean_ratio[3], difference.relative_rmse[3]);
        assert_true(difference.not_finite == 0);
        assert_true(difference.relative_rmse[3] <= rmse[i]);
        assert_close(difference.mean_ratio[3], 1, ratio[i]);
        ty_image_destroy(image);
    }
    ty_image_destroy(marched);
    ty_octaves_destroy(light);
    ty_scene_destroy(scene);
}

/* Layers and the image behind add up, and several rays per column change the light of columns with edges alone. */
static void channels_add_up(void** state) {
    ty_scene* scene = sunny_smoke(*state);
    ty_octaves_def def = octaves_def();
    ty_octaves* light = NULL;
    ty_image* surfaces = NULL;
    def.froxels = 20;
    def.froxel_slices = 16;
    def.spp = 4;
    check_result(*state, ty_octaves_solve(scene, &def, &light, NULL));
    check_result(*state, ty_image_create_rgb(*state, def.width, def.height, &surfaces));
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < def.width * def.height; ++i) ty_image_plane(surfaces, c)[i] = (float)(c + i % 7);
    def.unscattered = surfaces;
    ty_image* image = octaves_image(light, scene, &def);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < def.width * def.height; ++i) {
            const double single = (double)ty_image_plane_const(image, ty_image_find_channel(image, "single.R") + c)[i];
            const double multiple =
                (double)ty_image_plane_const(image, ty_image_find_channel(image, "multiple.R") + c)[i];
            const double sum = single + multiple + (double)ty_image_plane_const(surfaces, c)[i];
            assert_close((double)ty_image_plane_const(image, c)[i], sum, 1e-5 * (sum + 1));
        }
    assert_true(total(image, ty_image_find_channel(image, "single.R")) > 0);
    ty_image_destroy(image);
    ty_image_destroy(surfaces);
    ty_octaves_destroy(light);
    ty_scene_destroy(scene);
}

/* ---- cameras ---- */

/* Where no medium is in view, the sky is as it is; step and ray_spacing have no effect. */
static void nothing_in_view(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_camera_def camera = ty_scene_camera(scene);
    set3(camera.position, 0, 0, 9);
    set3(camera.target, 0, 0, 20);
    check_result(*state, ty_scene_set_camera(scene, &camera));
    ty_march_def def = march_def(5, 4);
    set_froxels(&def, 4, 3, 2);
    def.aovs = TY_AOV_TRANSMITTANCE;
    for (int i = 0; i < 2; ++i) {
        ty_image* image = march_image(scene, &def, NULL);
        for (int p = 0; p < 20; ++p) {
            assert_close(march_value(image, "transmittance.R", p), 1, 0);
            assert_close(march_value(image, "B", p), 0.75, 1e-6);
        }
        ty_image_destroy(image);
        def.step = 4;
        def.ray_spacing = 8;
    }
    ty_scene_destroy(scene);
}

/* ---- errors ---- */

static void wrong_froxels_are_refused(void** state) {
    static const int32_t sizes[][3] = {{4, 0, 4}, {0, 4, 4}, {-1, 4, 4}, {1025, 4, 4}, {4, 4, 1025}};
    static const char* const words[] = {"march.froxels[1]", "march.froxels[0]", "march.froxels[0]", "march.froxels[0]",
                                        "march.froxels[2]"};
    ty_scene* scene = foggy_scene(*state);
    ty_image* image = NULL;
    ty_march_def def = march_def(5, 4);
    for (int i = 0; i < 5; ++i) {
        set_froxels(&def, sizes[i][0], sizes[i][1], sizes[i][2]);
        assert_int_equal(ty_march(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, words[i]);
    }
    even_field even;
    even_begin(&even, low, high, 1);
    set_froxels(&def, 4, 4, 4);
    def.field = &even.field;
    assert_int_equal(ty_march(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "march.froxels: they hold no source field");
    ty_scene_destroy(scene);
}

static void refused_memory_leaves_nothing(void** state) {
    (void)state;
    strict_memory memory = {.limit = (size_t)1 << 28, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    ty_scene* scene = foggy_scene(context);
    ty_march_def def = march_def(5, 4);
    set_froxels(&def, 4, 4, 4);
    ty_image_destroy(march_image(scene, &def, NULL)); /* starts the context's threads */
    const size_t before = memory.used;
    ty_result result = TY_ERROR_MEMORY;
    int count = 0;
    for (; result != TY_OK; ++count) {
        ty_image* image = NULL;
        memory.until_refusal = count;
        result = ty_march(scene, &def, &image, NULL);
        memory.until_refusal = -1;
        assert_true(result == TY_OK || (result == TY_ERROR_MEMORY && image == NULL));
        ty_image_destroy(image);
        assert_int_equal(memory.used, before);
        if (result != TY_OK) assert_error(context, "memory");
    }
    assert_true(count > 3);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    assert_int_equal(memory.used, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_between_slices),   cmocka_unit_test(refinement_leads_to_the_march),
        cmocka_unit_test(channels_add_up),           cmocka_unit_test(nothing_in_view),
        cmocka_unit_test(wrong_froxels_are_refused), cmocka_unit_test(refused_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
