/* Screen-space scattering over a scene's own surfaces, held against path tracing: where it is exact, how far off it is
 * elsewhere, and that what scenes take by default (light scattered backwards is replaced by the mean around) is best.
 */
#include "truth.h"

enum { SIDE = 32, PIXEL_COUNT = SIDE * SIDE };

/* Treatment of light from outside the picture. */
typedef enum surroundings { NOTHING, IN_FULL, BALANCED } surroundings;

static void add_square(ty_scene* scene, double x, double y, double z, const double u[3], const double v[3], double half,
                       double albedo, double emission) {
    const double center[3] = {x, y, z};
    ty_shape_def square = square_shape(center, u, v, half, albedo);
    gray(square.emission, emission);
    add_shape(scene, &square);
}

/* A room 6 m wide whose walls glow, each by its own radiance, `behind` the one behind the camera; fog fills it,
 * with the camera inside. */
static ty_scene* empty_room(ty_context* context, const ty_medium_def* fog, double albedo, double behind) {
    static const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1};
    ty_scene* scene = new_scene(context);
    add_medium(scene, fog);
    add_square(scene, 0, 0, -3, x, y, 3, albedo, 0.5);
    add_square(scene, 0, 0, 3, y, x, 3, albedo, behind);
    add_square(scene, 0, -3, 0, z, x, 3, albedo, 0.3);
    add_square(scene, 0, 3, 0, x, z, 3, albedo, 0.7);
    add_square(scene, -3, 0, 0, y, z, 3, albedo, 0.2);
    add_square(scene, 3, 0, 0, z, y, 3, albedo, 1);
    set_camera(scene, 0, 0, 2.5, 50);
    commit(scene);
    return scene;
}

/* The same with two balls in it. */
static ty_scene* glowing_room(ty_context* context, const ty_medium_def* fog, double albedo, double behind) {
    ty_scene* scene = empty_room(context, fog, albedo, behind);
    const ty_shape_def bright = sphere_shape(-0.8, -0.3, -1, 0.5, albedo, 2);
    const ty_shape_def dark = sphere_shape(1, 0.4, -1.5, 0.4, albedo, 0.1);
    add_shape(scene, &bright);
    add_shape(scene, &dark);
    commit(scene);
    return scene;
}

/* Floor and balls under a sky of radiance 1, in ground fog 3 m high. */
static ty_scene* foggy_field(ty_context* context, double sigma_s, double g) {
    static const double x[3] = {1, 0, 0}, z[3] = {0, 0, 1};
    ty_scene* scene = new_scene(context);
    ty_medium_def fog = medium_cube(20, sigma_s, 0, g);
    fog.box_min[1] = -1.6;
    fog.box_max[1] = 1.5;
    const ty_light_def sky = light_of(TY_LIGHT_ENVIRONMENT, 1);
    const ty_shape_def near = sphere_shape(-0.8, -1, -1, 0.6, 0.2, 0), far = sphere_shape(2, -0.2, -5, 1.4, 0.1, 0);
    add_medium(scene, &fog);
    add_light(scene, &sky);
    add_square(scene, 0, -1.6, 0, z, x, 40, 0.3, 0);
    add_shape(scene, &near);
    add_shape(scene, &far);
    set_camera(scene, 0, 0, 4, 50);
    commit(scene);
    return scene;
}

static ty_image* render_surfaces(const ty_scene* scene, int32_t spp, uint64_t seed, bool ignore_media) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.seed = seed;
    def.width = def.height = SIDE;
    def.aovs = TY_AOV_DEPTH;
    def.ignore_media = ignore_media;
    ty_image* image = NULL;
    must(ty_scene_context(scene), ty_path_render(scene, &def, &image, NULL));
    return image;
}

static void find_radiance_around(const ty_scene* scene, float radiance[3]) {
    static const int32_t size[3] = {1, 1, 1};
    const ty_camera_def camera = ty_scene_camera(scene);
    double fluence[3];
    ty_path_def def = ty_default_path_def();
    def.spp = 1 << 14;
    def.ignore_media = true;
    must(ty_scene_context(scene),
         ty_path_fluence(scene, &def, camera.position, camera.position, size, fluence, NULL, NULL));
    for (int c = 0; c < 3; ++c) radiance[c] = (float)(fluence[c] / (4 * pi));
}

/* The image of `tyndall render --method screen`. */
static ty_image* render_screen(const ty_scene* scene, int32_t spp, uint64_t seed, surroundings around) {
    ty_context* context = ty_scene_context(scene);
    ty_image* image = render_surfaces(scene, spp, seed, true);
    float* distance = ty_image_plane(image, ty_image_find_channel(image, "depth.Z"));
    ty_screen_image planes = ty_default_screen_image();
    planes.width = planes.height = SIDE;
    planes.distance = distance;
    planes.distance_row = SIDE;
    planes.color.row = SIDE;
    for (int c = 0; c < 3; ++c) planes.color.data[c] = ty_image_plane(image, c);
    planes.out = planes.color;
    ty_screen_def def = ty_default_screen_def();
    must(context, ty_screen_set_scene(scene, SIDE, &def));
    float radiance[3] = {0, 0, 0};
    if (around != NOTHING) find_radiance_around(scene, radiance);
    if (around == BALANCED) ty_screen_balance(&def, radiance);
    if (around == IN_FULL) memcpy(def.environment, radiance, sizeof radiance);
    must(context, ty_screen_scene_distance(scene, SIDE, SIDE, distance));
    must(context, ty_screen_apply(context, &def, &planes, NULL, 0, NULL));
    return image;
}

/* Difference of the scene's screen image from the path-traced one, in means of blocks, since paths are noisy. */
static ty_difference measure(const char* name, const ty_scene* scene, const ty_image* truth, surroundings around,
                             int32_t block) {
    static const char* const words[] = {"nothing around", "around in full", "balanced"};
    ty_image* image = render_screen(scene, 64, 5, around);
    ty_difference difference;
    must(ty_scene_context(scene), ty_image_compare(ty_scene_context(scene), image, truth, block, &difference));
    printf("%-34s %-15s mean ratio %.3f, relative RMSE of %dx%d blocks %.3f\n", name, words[around],
           difference.mean_ratio[3], block, block, difference.relative_rmse[3]);
    ty_image_destroy(image);
    return difference;
}

static bool same_pixels(const ty_image* a, const ty_image* b) {
    for (int c = 0; c < 3; ++c)
        if (memcmp(ty_image_plane_const(a, c), ty_image_plane_const(b, c), PIXEL_COUNT * sizeof(float)) != 0)
            return false;
    return true;
}

static void clear_air_changes_nothing(void** state) {
    const ty_medium_def clear = medium_cube(3.1, 0, 0, 0);
    ty_scene* scene = glowing_room(*state, &clear, 0.5, 1);
    ty_image *screen = render_screen(scene, 16, 2, BALANCED), *path = render_surfaces(scene, 16, 2, true);
    assert_true(same_pixels(screen, path));
    ty_image_destroy(screen);
    ty_image_destroy(path);
    ty_scene_destroy(scene);
}

/* exp(-sigma_a D) is all there is, per channel; what is left is that D is a pixel's mean, where walls meet. */
static void absorption_is_exact(void** state) {
    ty_medium_def dark = medium_cube(3.1, 0, 0, 0);
    rgb(dark.sigma_a, 0.1, 0.3, 0.6);
    ty_scene* scene = empty_room(*state, &dark, 0, 1);
    ty_image *screen = render_screen(scene, 64, 2, BALANCED), *path = render_surfaces(scene, 64, 2, false);
    ty_difference difference;
    must(*state, ty_image_compare(*state, screen, path, 1, &difference));
    for (int c = 0; c < 3; ++c) {
        printf("absorption, %c: mean ratio %.5f, relative RMSE %.5f\n", "RGB"[c], difference.mean_ratio[c],
               difference.relative_rmse[c]);
        assert_true(fabs(difference.mean_ratio[c] - 1) < 2e-4);
        assert_true(difference.relative_rmse[c] < 3e-4);
    }
    ty_image_destroy(screen);
    ty_image_destroy(path);
    ty_scene_destroy(scene);
}

/* Forward scattering, optical thickness 1 and 2 to the far wall. The truth itself is noisy: 3% and 6% in such blocks,
 * 4% in quick runs, which have the thinner one. */
static void forward_fog_is_near_path(void** state) {
    static const double sigma_s[] = {0.18, 0.36};
    for (int i = 0; i < (in_full() ? 2 : 1); ++i) {
        const ty_medium_def fog = medium_cube(3.1, sigma_s[i], 0, 0.9);
        ty_scene* scene = glowing_room(*state, &fog, 0, 1);
        ty_image* truth = render_surfaces(scene, fewer(4096, 4), 1, false);
        const ty_difference difference =
            measure(i == 0 ? "g 0.9, thickness 1" : "g 0.9, thickness 2", scene, truth, BALANCED, 8);
        assert_true(fabs(difference.mean_ratio[3] - 1) < 0.04);
        assert_true(difference.relative_rmse[3] < 0.13);
        ty_image_destroy(truth);
        ty_scene_destroy(scene);
    }
}

/* Isotropic fog: half of what it scatters never was in the picture. */
static void isotropic_fog_lacks_half_of_its_light(void** state) {
    static const double behind[] = {0.1, 3};
    for (int i = 0; i < 2; ++i) {
        const ty_medium_def fog = medium_cube(3.1, 0.25, 0, 0);
        ty_scene* scene = glowing_room(*state, &fog, 0.3, behind[i]);
        const char* name = i == 0 ? "g 0, dark behind the camera" : "g 0, bright behind the camera";
        ty_image* truth = render_surfaces(scene, fewer(512, 4), 1, false);
        const ty_difference none = measure(name, scene, truth, NOTHING, 4);
        const ty_difference balanced = measure(name, scene, truth, BALANCED, 4);
        const ty_difference full = measure(name, scene, truth, IN_FULL, 4);
        assert_true(balanced.relative_rmse[3] < 0.8 * none.relative_rmse[3]);
        assert_true(fabs(balanced.mean_ratio[3] - 1) < 0.08);
        assert_true(full.mean_ratio[3] > 1.3);
        ty_image_destroy(truth);
        ty_scene_destroy(scene);
    }
}

/* A sky above ground fog. */
static void the_sky_is_far_away(void** state) {
    static const double g[] = {0, 0.5, 0.9};
    for (int i = 0; i < 3; i += in_full() ? 1 : 2) {
        ty_scene* scene = foggy_field(*state, 0.2, g[i]);
        char name[32];
        snprintf(name, sizeof name, "sky, g %g", g[i]);
        ty_image* truth = render_surfaces(scene, fewer(512, 4), 1, false);
        const ty_difference none = measure(name, scene, truth, NOTHING, 4);
        const ty_difference balanced = measure(name, scene, truth, BALANCED, 4);
        const ty_difference full = measure(name, scene, truth, IN_FULL, 4);
        assert_true(fabs(balanced.mean_ratio[3] - 1) < 0.12);
        assert_true(balanced.relative_rmse[3] < 1.02 * none.relative_rmse[3]);
        assert_true(full.relative_rmse[3] > 2 * balanced.relative_rmse[3]);
        ty_image_destroy(truth);
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clear_air_changes_nothing), cmocka_unit_test(absorption_is_exact),
        cmocka_unit_test(forward_fog_is_near_path),  cmocka_unit_test(isotropic_fog_lacks_half_of_its_light),
        cmocka_unit_test(the_sky_is_far_away),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
