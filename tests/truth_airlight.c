/* Airlight against path tracing's light that media scatter once: fog with blocks in it, under each kind of light. */
#include "base/context.h"
#include "method/lpv/image/airlight.h"
#include "scene/camera.h"
#include "truth.h"

enum { WIDTH = 64, HEIGHT = 48, RAYS = 4, PASSES = 160, MAP_SIDE = 512 };

typedef enum density { EVEN, UNEVEN } density;

static ty_grid* noise_of(ty_context* context) {
    ty_noise_def noise = ty_default_noise_def();
    ty_grid* grid = NULL;
    noise.kind = TY_NOISE_FBM;
    noise.size[0] = noise.size[1] = noise.size[2] = 48;
    noise.octaves = 3;
    must(context, ty_grid_create_noise(context, &noise, &grid));
    return grid;
}

/* A room without walls, 6 m wide: a floor and four blocks in a box of fog. */
static ty_scene* blocks_in_fog(ty_context* context, const ty_light_def* light, double g, density kind) {
    static const double block[4][6] = {{-1.6, -1, -0.8, 0.5, 1.5, 0.5},
                                       {0.2, -1, -1.4, 0.6, 0.9, 0.6},
                                       {1.2, -1, 0.3, 0.4, 2, 0.4},
                                       {-0.7, 0.8, -0.6, 1.4, 0.1, 1}};
    ty_scene* scene = new_scene(context);
    ty_medium_def fog = medium_cube(3, 0.15, 0.05, g);
    fog.box_min[1] = -1;
    fog.box_max[1] = 2.5;
    rgb(fog.sigma_s, 0.12, 0.15, 0.2);
    if (kind == UNEVEN) fog.density_grid = noise_of(context);
    if (kind == UNEVEN) fog.scale = 3;
    add_medium(scene, &fog);
    ty_grid_release(fog.density_grid);
    add_light(scene, light);
    ty_shape_def floor = ty_default_shape_def();
    floor.kind = TY_SHAPE_BOX;
    set3(floor.origin, -3, -1.2, -3);
    set3(floor.u, 3, -1, 3);
    add_shape(scene, &floor);
    for (int i = 0; i < 4; ++i) {
        ty_shape_def box = floor;
        set3(box.origin, block[i][0], block[i][1], block[i][2]);
        set3(box.u, block[i][0] + block[i][3], block[i][1] + block[i][4], block[i][2] + block[i][5]);
        add_shape(scene, &box);
    }
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0.3, 0.9, 4);
    set3(camera.target, 0, 0.3, 0);
    camera.fov_y = 50;
    must(context, ty_scene_set_camera(scene, &camera));
    commit(scene);
    return scene;
}

/* ---- images ---- */

typedef struct eye_ray {
    ty_vec way;
    float far;
} eye_ray;

/* Rays at even places of each pixel, as far as the first surface. */
static ty_vec find_rays(const ty_scene* scene, eye_ray* rays) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    const ty_camera_def def = ty_scene_camera(scene);
    const ty_camera_view camera = ty_camera_get_view(&def, WIDTH, HEIGHT);
    for (int32_t i = 0; i < RAYS * WIDTH * HEIGHT; ++i) {
        const int32_t pixel = i / RAYS;
        double at[4];
        ty_hit hit;
        even_point(i, at);
        rays[i].way =
            ty_camera_direction(&camera, (float)(pixel % WIDTH + at[0]), (float)((int)(pixel / WIDTH) + at[1]));
        const bool met = ty_accel_intersect(view->mesh, camera.origin, rays[i].way, TY_FLOAT_MAX, &hit);
        rays[i].far = met ? hit.distance : INFINITY;
    }
    return camera.origin;
}

/* Airlight, the mean of the channels, and the processor seconds that it takes. */
static double airlight_image(const ty_scene* scene, const ty_airlight* airlight, double* image) {
    static eye_ray rays[RAYS * WIDTH * HEIGHT];
    const ty_vec eye = find_rays(scene, rays);
    const double begun = ty_cpu_seconds();
    memset(image, 0, WIDTH * HEIGHT * sizeof *image);
    for (int32_t i = 0; i < RAYS * WIDTH * HEIGHT; ++i) {
        float radiance[3];
        ty_airlight_ray(airlight, eye, rays[i].way, rays[i].far, 1, radiance, NULL);
        for (int c = 0; c < 3; ++c) image[i / RAYS] += (double)radiance[c] / (3 * RAYS);
    }
    return ty_cpu_seconds() - begun;
}

static void path_image(const ty_scene* scene, int32_t spp, uint64_t seed, double* image) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.seed = seed;
    def.width = WIDTH;
    def.height = HEIGHT;
    def.aovs = TY_AOV_SINGLE;
    def.max_depth = 1;
    ty_image* rendered = NULL;
    must(ty_scene_context(scene), ty_path_render(scene, &def, &rendered, NULL));
    const int first = ty_image_find_channel(rendered, "single.R");
    assert_true(first >= 0);
    for (int32_t i = 0; i < WIDTH * HEIGHT; ++i) {
        image[i] = 0;
        for (int c = 0; c < 3; ++c) image[i] += (double)ty_image_plane_const(rendered, first + c)[i] / 3;
    }
    ty_image_destroy(rendered);
}

/* ---- how they differ ---- */

/* Pixels about a lamp that is seen are so bright that nothing else would count. */
static const double brightest = 8;

/* Two path-traced images of half of the samples each tell the noise. */
static void compare(const char* name, const double* image, double* const halves[2], double seconds) {
    double mean = 0, wanted = 0, error = 0, square = 0, noise = 0;
    for (int32_t i = 0; i < WIDTH * HEIGHT; ++i) wanted += 0.5 * (halves[0][i] + halves[1][i]);
    const double most = brightest * wanted / (WIDTH * HEIGHT);
    for (int32_t i = 0; i < WIDTH * HEIGHT; ++i) {
        const double a = fmin(halves[0][i], most), b = fmin(halves[1][i], most), off = fmin(image[i], most);
        mean += image[i];
        error += 0.25 * (halves[0][i] - halves[1][i]) * (halves[0][i] - halves[1][i]);
        square += (off - 0.5 * (a + b)) * (off - 0.5 * (a + b));
        noise += 0.25 * (a - b) * (a - b);
    }
    const double count = WIDTH * HEIGHT, ratio = mean / wanted, unit = wanted / count;
    error = sqrt(error) / count / unit;
    const double rmse = sqrt(fmax(0, square - noise) / count) / unit;
    printf("%-20s mean ratio %.4f +- %.4f, relative RMSE net of noise %.4f (noise %.4f), %.0f ns a ray\n", name, ratio,
           error, rmse, sqrt(noise / count) / unit, 1e9 * seconds / (count * RAYS));
    if (!(error < 0.005)) fail_msg("%s: too noisy to tell", name);
    if (!(fabs(ratio - 1) < 0.02)) fail_msg("%s: the means' ratio is %g", name, ratio);
    if (!(rmse < 0.1)) fail_msg("%s: the images differ by %g", name, rmse);
}

static void check(ty_context* context, const char* name, const ty_light_def* light, double g, density kind) {
    static double image[WIDTH * HEIGHT], first[WIDTH * HEIGHT], second[WIDTH * HEIGHT];
    static const double lower[3] = {-3, -1.2, -3}, upper[3] = {3, 2.5, 3};
    double* const halves[2] = {first, second};
    ty_scene* scene = blocks_in_fog(context, light, g, kind);
    const ty_light_view* view = &ty_scene_get_view(scene)->lights.lights[0];
    const ty_rsm_def map_def = {.side = MAP_SIDE, .lower = lower, .upper = upper};
    ty_grid_box box;
    ty_grid_medium* medium = NULL;
    ty_rsm* map = NULL;
    ty_shadow_hierarchy* lit = NULL;
    ty_airlight* airlight = NULL;
    must(context, ty_grid_box_fit(scene, 48, &box));
    must(context, ty_grid_medium_create(scene, &box, &medium));
    must(context, ty_rsm_trace(scene, &map_def, 0, &map, NULL));
    must(context, ty_shadow_hierarchy_create(context, view, map, &lit));
    const ty_shadow_hierarchy* const maps[1] = {lit};
    const ty_airlight_def def = {.medium = medium, .maps = maps, .count = 1};
    must(context, ty_airlight_create(scene, &def, &airlight));
    const double seconds = airlight_image(scene, airlight, image);
    for (int i = 0; i < 2; ++i) path_image(scene, PASSES, 1 + (uint64_t)i, halves[i]);
    compare(name, image, halves, seconds);
    ty_airlight_destroy(airlight);
    ty_shadow_hierarchy_destroy(lit);
    ty_rsm_destroy(context, map);
    ty_grid_medium_destroy(medium);
    ty_scene_destroy(scene);
}

static void airlight_of_the_sun_is_right(void** state) {
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 2);
    set3(sun.direction, -0.5, -1, -0.35);
    if (in_full()) check(*state, "sun, g 0", &sun, 0, EVEN);
    check(*state, "sun, g 0.7", &sun, 0.7, EVEN);
    check(*state, "sun, g 0.4, uneven", &sun, 0.4, UNEVEN);
}

static void airlight_of_a_point_light_is_right(void** state) {
    ty_light_def point = light_of(TY_LIGHT_POINT, 2);
    set3(point.position, 0.4, 1.3, -0.3);
    if (in_full()) check(*state, "point, g 0", &point, 0, EVEN);
    check(*state, "point, g 0.7", &point, 0.7, EVEN);
    check(*state, "point, g 0.4, uneven", &point, 0.4, UNEVEN);
}

static void airlight_of_a_spot_light_is_right(void** state) {
    ty_light_def spot = light_of(TY_LIGHT_SPOT, 4);
    set3(spot.position, 1.4, 3.2, 1.2);
    set3(spot.direction, -0.5, -1, -0.4);
    spot.cone = 60;
    spot.penumbra = 0.3;
    if (in_full()) check(*state, "spot, g 0", &spot, 0, EVEN);
    check(*state, "spot, g 0.7", &spot, 0.7, EVEN);
    check(*state, "spot, g 0.4, uneven", &spot, 0.4, UNEVEN);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(airlight_of_the_sun_is_right),
        cmocka_unit_test(airlight_of_a_point_light_is_right),
        cmocka_unit_test(airlight_of_a_spot_light_is_right),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
