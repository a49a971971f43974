/* Inputs of screen-space scattering from scenes: coefficients, the camera, distances inside media. */
#include "checks.h"

#include <stdio.h>

enum { WIDTH = 9, HEIGHT = 7, PIXELS = WIDTH * HEIGHT, MIDDLE = HEIGHT / 2 * WIDTH + WIDTH / 2 };

/* The last warning, and how many there were. */
typedef struct warnings {
    int count;
    char last[256];
} warnings;

static void keep_warning(void* user, ty_log_level level, const char* text) {
    warnings* kept = user;
    if (level != TY_LOG_WARNING) return;
    ++kept->count;
    snprintf(kept->last, sizeof kept->last, "%s", text);
}

typedef struct fixture {
    warnings warned;
    ty_context* context;
    ty_scene* scene;
} fixture;

static int start(void** state) {
    fixture* f = calloc(1, sizeof *f);
    ty_context_def def = ty_default_context_def();
    def.threads = 2;
    def.log = keep_warning;
    def.log_user = &f->warned;
    if (ty_context_create(&def, &f->context) != TY_OK) return -1;
    f->scene = make_scene(f->context);
    *state = f;
    return 0;
}

static int stop(void** state) {
    fixture* f = *state;
    ty_scene_destroy(f->scene);
    ty_context_destroy(f->context);
    free(f);
    return 0;
}

/* A camera at the origin that looks along -z. */
static void set_camera(ty_scene* scene) {
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0, 0, 0);
    set3(camera.target, 0, 0, -1);
    camera.fov_y = 90;
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
}

/* Fog in a cube about the camera. */
static ty_medium_def fog(double half, float sigma_s, float sigma_a, float g) {
    const double lower[3] = {-half, -half, -half}, upper[3] = {half, half, half};
    ty_medium_def def = box_medium(lower, upper, sigma_s, sigma_a);
    set3f(def.g, g, g, g);
    return def;
}

static void commit_with(fixture* f, const ty_medium_def* a, const ty_medium_def* b) {
    set_camera(f->scene);
    if (a != NULL) assert_int_equal(ty_scene_add_medium(f->scene, a), TY_OK);
    if (b != NULL) assert_int_equal(ty_scene_add_medium(f->scene, b), TY_OK);
    assert_int_equal(ty_scene_commit(f->scene), TY_OK);
}

static void find_distances(const fixture* f, float surfaces, float distance[PIXELS]) {
    for (int i = 0; i < PIXELS; ++i) distance[i] = surfaces;
    assert_int_equal(ty_screen_scene_distance(f->scene, WIDTH, HEIGHT, distance), TY_OK);
}

static void coefficients_add(void** state) {
    fixture* f = *state;
    ty_medium_def a = fog(3, 1, 0.25f, 0.5f);
    const ty_medium_def b = fog(3, 3, 0, 0.9f), empty = fog(1, 0, 0, 0);
    a.scale = 2;
    a.sigma_a[1] = 0;
    commit_with(f, &a, &b);
    assert_int_equal(ty_scene_add_medium(f->scene, &empty), TY_OK);
    assert_int_equal(ty_scene_commit(f->scene), TY_OK);
    ty_screen_def def = ty_default_screen_def();
    assert_int_equal(ty_screen_set_scene(f->scene, 100, &def), TY_OK);
    assert_close(def.sigma_s[0], 5, 1e-6);
    assert_close(def.sigma_a[0], 0.5, 1e-6);
    assert_close(def.sigma_a[1], 0, 1e-6);
    assert_close(def.g[2], (2 * 0.5 + 3 * 0.9) / 5, 1e-6);
    assert_close(def.focal[0], 50, 1e-9); /* tan(45 degrees) = 1 */
    assert_close(def.focal[1], 50, 1e-9);
    assert_int_equal(def.distance_kind, TY_SCREEN_DISTANCE_RAY);
    assert_int_equal(f->warned.count, 0);
}

static void clear_scenes_have_no_medium(void** state) {
    fixture* f = *state;
    commit_with(f, NULL, NULL);
    ty_screen_def def = ty_default_screen_def();
    def.sigma_s[0] = 7;
    def.g[1] = 0.5f;
    assert_int_equal(ty_screen_set_scene(f->scene, 0, &def), TY_OK);
    for (int c = 0; c < 3; ++c) assert_true(def.sigma_s[c] == 0 && def.sigma_a[c] == 0 && def.g[c] == 0);
    assert_close(def.focal[0], 300, 1e-9); /* of the camera's own 600 rows */
    float distance[PIXELS];
    find_distances(f, 4, distance);
    for (int i = 0; i < PIXELS; ++i) assert_true(distance[i] > 0 && distance[i] < 1e-6f);
}

static void distances_end_where_media_do(void** state) {
    fixture* f = *state;
    const ty_medium_def medium = fog(3, 1, 0, 0);
    commit_with(f, &medium, NULL);
    float distance[PIXELS];
    find_distances(f, 2, distance); /* surfaces in the fog */
    for (int i = 0; i < PIXELS; ++i) assert_close(distance[i], 2, 1e-5);
    const float unknown[] = {0, -1, INFINITY, NAN, 1000};
    for (int k = 0; k < 5; ++k) {
        find_distances(f, unknown[k], distance);
        assert_close(distance[MIDDLE], 3, 1e-5);
        const double x = 8.0 / HEIGHT, y = 6.0 / HEIGHT; /* tangents of the corner's ray, which leaves at the side */
        assert_close(distance[0], 3 / fmax(x, 1) * sqrt(1 + x * x + y * y), 1e-4);
    }
    assert_int_equal(f->warned.count, 0);
}

static void media_ahead_are_warned_of(void** state) {
    fixture* f = *state;
    ty_medium_def medium = fog(3, 1, 0, 0);
    medium.box_max[2] = -2;
    commit_with(f, &medium, NULL);
    float distance[PIXELS];
    find_distances(f, 2.5f, distance);
    assert_close(distance[MIDDLE], 0.5, 1e-5);
    assert_int_equal(f->warned.count, 1);
    assert_non_null(strstr(f->warned.last, "outside a medium"));
}

static void optical_depth_is_kept(void** state) {
    fixture* f = *state;
    const ty_medium_def wide = fog(3, 1, 0, 0), narrow = fog(1, 2, 1, 0.5f);
    commit_with(f, &wide, &narrow);
    float distance[PIXELS];
    find_distances(f, 0, distance);
    assert_close(distance[MIDDLE] * 4, 3 * 1 + 1 * 3, 1e-4);
    assert_int_equal(f->warned.count, 1);
    assert_non_null(strstr(f->warned.last, "do not fill the same space"));
}

static void media_that_glow_are_warned_of(void** state) {
    fixture* f = *state;
    ty_medium_def medium = fog(3, 1, 1, 0);
    medium.name = "embers";
    set3f(medium.emission, 1, 0, 0);
    commit_with(f, &medium, NULL);
    float distance[PIXELS];
    find_distances(f, 1, distance);
    assert_int_equal(f->warned.count, 1);
    assert_non_null(strstr(f->warned.last, "media[0] (embers) itself sends"));
}

static void uneven_media_are_refused(void** state) {
    fixture* f = *state;
    static const float values[8] = {0, 1, 0, 1, 0, 1, 0, 1};
    ty_grid_def grid = ty_default_grid_def();
    grid.size[0] = grid.size[1] = grid.size[2] = 2;
    grid.values = values;
    ty_medium_def medium = fog(3, 1, 0, 0), even = fog(3, 1, 0, 0);
    medium.name = "smoke";
    assert_int_equal(ty_grid_create(f->context, &grid, &medium.density_grid), TY_OK);
    commit_with(f, &even, &medium);
    ty_grid_release(medium.density_grid);
    ty_screen_def def = ty_default_screen_def();
    assert_int_equal(ty_screen_set_scene(f->scene, 0, &def), TY_ERROR_ARGUMENT);
    assert_error(f->context, "media[1] (smoke) is not homogeneous");
}

static void wrong_calls_are_refused(void** state) {
    fixture* f = *state;
    ty_screen_def def = ty_default_screen_def();
    float distance[PIXELS];
    assert_int_equal(ty_screen_set_scene(f->scene, 0, &def), TY_ERROR_ARGUMENT);
    assert_error(f->context, "not committed");
    assert_int_equal(ty_screen_scene_distance(f->scene, WIDTH, HEIGHT, distance), TY_ERROR_ARGUMENT);
    assert_error(f->context, "not committed");
    commit_with(f, NULL, NULL);
    def.cookie = 0;
    assert_int_equal(ty_screen_set_scene(f->scene, 0, &def), TY_ERROR_ARGUMENT);
    assert_error(f->context, "ty_default_screen_def");
    assert_int_equal(ty_screen_scene_distance(f->scene, WIDTH, HEIGHT, NULL), TY_ERROR_ARGUMENT);
    assert_error(f->context, "distance is NULL");
    assert_int_equal(ty_screen_scene_distance(f->scene, 0, HEIGHT, distance), TY_ERROR_ARGUMENT);
    assert_error(f->context, "0 x 7");
    assert_int_equal(ty_screen_scene_distance(f->scene, WIDTH, 65537, distance), TY_ERROR_ARGUMENT);
    assert_error(f->context, "9 x 65537");
}

static void environments_have_a_mean(void** state) {
    fixture* f = *state;
    float radiance[3] = {9, 9, 9};
    ty_scene_environment(f->scene, radiance);
    for (int c = 0; c < 3; ++c) assert_true(radiance[c] == 0);
    ty_light_def sun = ty_default_light_def(), sky = sun, map = sun;
    sky.kind = map.kind = TY_LIGHT_ENVIRONMENT;
    set3f(sky.color, 1, 2, 3);
    sky.scale = 2;
    ty_image* image = NULL;
    assert_int_equal(ty_image_create_rgb(f->context, 8, 4, &image), TY_OK);
    for (int i = 0; i < 16; ++i) ty_image_plane(image, 1)[i] = 10; /* green above the horizon */
    map.image = image;
    assert_int_equal(ty_scene_add_light(f->scene, &sun), TY_OK);
    assert_int_equal(ty_scene_add_light(f->scene, &sky), TY_OK);
    assert_int_equal(ty_scene_add_light(f->scene, &map), TY_OK);
    ty_image_destroy(image);
    ty_scene_environment(f->scene, radiance);
    assert_close(radiance[0], 2, 1e-5);
    assert_close(radiance[1], 4 + 5, 1e-4);
    assert_close(radiance[2], 6, 1e-5);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, start, stop)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(coefficients_add),          TEST(clear_scenes_have_no_medium), TEST(distances_end_where_media_do),
        TEST(media_ahead_are_warned_of), TEST(optical_depth_is_kept),       TEST(media_that_glow_are_warned_of),
        TEST(uneven_media_are_refused),  TEST(wrong_calls_are_refused),     TEST(environments_have_a_mean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
