/* A scene that is not ours, with its author's picture: the camera of the file frames it as the author did, textures lie
 * where they should, and diffuse walls are as bright as they can be where wood is not varnished. */
#include "truth.h"

enum { WIDTH = 90, HEIGHT = 160, SHRINK = 8 };

static ty_scene* load_staircase(ty_context* context, bool gloss) {
    char path[1024];
    if (data_path("scenes/wooden_staircase.glb", path) == NULL) return NULL;
    ty_scene* scene = new_scene(context);
    ty_mesh_file_def def = ty_default_mesh_file_def();
    def.gloss = gloss;
    must(context, ty_scene_add_mesh_file(scene, path, &def));
    ty_camera_def camera = ty_default_camera_def();
    bool found = false;
    must(context, ty_mesh_file_camera(context, path, &def, NULL, &camera, &found));
    assert_true(found);
    assert_true(fabs(camera.fov_y - 1.021785200385582 * 180 / pi) < 1e-9);
    camera.resolution[0] = WIDTH * SHRINK;
    camera.resolution[1] = HEIGHT * SHRINK;
    must(context, ty_scene_set_camera(scene, &camera));
    must(context, ty_scene_commit(scene));
    return scene;
}

static ty_image* load_reference(ty_context* context) {
    char path[1024];
    ty_image* image = NULL;
    if (data_path("scenes/wooden_staircase_reference.exr", path) == NULL) return NULL;
    must(context, ty_image_read(context, path, &image));
    assert_int_equal(ty_image_width(image), WIDTH * SHRINK);
    assert_int_equal(ty_image_height(image), HEIGHT * SHRINK);
    return image;
}

/* The logarithm of green, by blocks of SHRINK pixels. */
static double block_log(const float* plane, int32_t x, int32_t y) {
    double sum = 0;
    for (int32_t j = 0; j < SHRINK; ++j)
        for (int32_t i = 0; i < SHRINK; ++i) sum += (double)plane[(SHRINK * y + j) * WIDTH * SHRINK + SHRINK * x + i];
    return log(sum + 0.01);
}

/* Correlation of a small picture with the reference moved by (dx, dy) blocks. */
static double correlation(const float* small, const float* reference, int32_t dx, int32_t dy) {
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (int32_t y = 4; y < HEIGHT - 4; ++y)
        for (int32_t x = 4; x < WIDTH - 4; ++x) {
            const double u = log((double)small[y * WIDTH + x] + 0.01 / SHRINK / SHRINK);
            const double v = block_log(reference, x + dx, y + dy);
            n += 1;
            a += u;
            b += v;
            aa += u * u;
            bb += v * v;
            ab += u * v;
        }
    return (ab - a * b / n) / sqrt((aa - a * a / n) * (bb - b * b / n));
}

static void the_picture_is_framed_alike(void** state) {
    ty_scene* scene = load_staircase(*state, true);
    if (scene == NULL) return;
    ty_image *image = NULL, *reference = load_reference(*state);
    ty_path_def def = ty_default_path_def();
    def.spp = 32;
    def.width = WIDTH;
    def.height = HEIGHT;
    must(*state, ty_path_render(scene, &def, &image, NULL));
    assert_finite(image);
    const float* small = ty_image_plane_const(image, ty_image_find_channel(image, "G"));
    const float* large = ty_image_plane_const(reference, ty_image_find_channel(reference, "G"));
    const double here = correlation(small, large, 0, 0);
    printf("correlation of log green: %.4f; moved by a block: %.4f %.4f %.4f %.4f\n", here,
           correlation(small, large, 1, 0), correlation(small, large, -1, 0), correlation(small, large, 0, 1),
           correlation(small, large, 0, -1));
    /* Measured: 0.853 (0.841 without gloss), varnish being absent here, and 0.032 to 0.043 less when moved by a block.
     * The bounds are half of what moving takes: a frame that is half a block off fails. */
    assert_true(here > 0.853 - 0.016);
    for (int32_t d = -1; d <= 1; d += 2) {
        assert_true(correlation(small, large, d, 0) < here - 0.025);
        assert_true(correlation(small, large, 0, d) < here - 0.025);
    }
    ty_image_destroy(image);
    ty_image_destroy(reference);
    ty_scene_destroy(scene);
}

/* Without gloss, because the author's wallpaper has none, where the file says that of an ior of 1.5. Blue, which
 * varnished wood hardly sends: the light on the wallpaper under the lamp is nearly all direct. Red and green are
 * brighter than the author's by the varnish that is missing here. The bounds are 2 % about the ratios measured;
 * the mean of 20,000 pixels at 48 samples has a noise of 0.2 %. */
static void a_diffuse_wall_is_as_bright(void** state) {
    static const double measured[3] = {1.226, 1.155, 1.092};
    ty_scene* scene = load_staircase(*state, false);
    if (scene == NULL) return;
    ty_image *image = NULL, *reference = load_reference(*state);
    ty_path_def def = ty_default_path_def();
    def.spp = 48;
    const int32_t crop[4] = {450, 180, 200, 100};
    memcpy(def.crop, crop, sizeof crop);
    must(*state, ty_path_render(scene, &def, &image, NULL));
    ty_difference difference;
    must(*state, ty_image_compare(*state, image, reference, 1, &difference));
    printf("wallpaper, ours / theirs: %.3f %.3f %.3f\n", difference.mean_ratio[0], difference.mean_ratio[1],
           difference.mean_ratio[2]);
    for (int c = 0; c < 3; ++c) assert_true(fabs(difference.mean_ratio[c] / measured[c] - 1) <= 0.02);
    ty_image_destroy(image);
    ty_image_destroy(reference);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_picture_is_framed_alike),
        cmocka_unit_test(a_diffuse_wall_is_as_bright),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
