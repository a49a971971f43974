/* Uncollided light on a grid against path tracing: every kind of light in an uneven medium with things that cast
 * shadows. */
#include "direct/lights/discretize.h"
#include "direct/uncollided/uncollided.h"
#include "truth.h"
#include "triangle_maker.h"

/* Near lamps a few samples carry most of the light: two runs with fewer do not tell how noisy they are. Farther from
 * lamps half of them leave 3.4 standard errors of the mean ratio between what is measured and its bound. */
enum { NEAR_SPP = 1024 };

enum { COARSE = 8, FINE = 32, FINER = 64, BRIGHT = 60 };

typedef enum surroundings { BARE, SHADOWED } surroundings;

/* A cube of noise about the origin, half side 1; where shadowed, a ball inside and a board above half of it. */
static ty_scene* noise_scene(ty_context* context, surroundings around, double density) {
    ty_scene* scene = new_scene(context);
    ty_medium_def cloud = medium_cube(1, density, 0.2 * density, 0.4);
    rgb(cloud.sigma_s, 0.5 * density, density, 2 * density);
    ty_noise_def noise = ty_default_noise_def();
    noise.kind = TY_NOISE_FBM;
    noise.size[0] = noise.size[1] = noise.size[2] = FINE;
    noise.octaves = 3;
    must(context, ty_grid_create_noise(context, &noise, &cloud.density_grid));
    add_medium(scene, &cloud);
    ty_grid_release(cloud.density_grid);
    if (around == BARE) return scene;
    static const double center[3] = {0.8, 1.4, 0}, u[3] = {0, 0, 1}, v[3] = {1, 0, 0};
    const ty_shape_def ball = sphere_shape(-0.3, 0.1, 0.2, 0.35, 0, 0), board = square_shape(center, u, v, 0.8, 0);
    add_shape(scene, &ball);
    add_shape(scene, &board);
    return scene;
}

/* All sources of a scene on the medium's cells, and their means over coarser ones. */
static void light_grid(const ty_scene* scene, int32_t longest, float* fluence[3]) {
    static const int32_t coarse[3] = {COARSE, COARSE, COARSE};
    ty_context* context = ty_scene_context(scene);
    ty_grid_box box;
    ty_grid_medium* medium = NULL;
    ty_light_field* field = NULL;
    ty_discrete_light_set sources;
    ty_discretize_def def = ty_default_discretize_def();
    def.environment = 128;
    def.surface = 256;
    must(context, ty_grid_box_fit(scene, longest, &box));
    for (int a = 0; a < 3; ++a) box.size[a] = longest; /* finer than voxels, even */
    must(context, ty_grid_medium_create(scene, &box, &medium));
    must(context, ty_light_field_create(medium, true, &field));
    must(context, ty_discretize_lights(scene, &def, &sources));
    must(context, ty_uncollided_add(scene, medium, NULL, sources.items, sources.count, field));
    for (int c = 0; c < 3; ++c) ty_grid_average(context, field->fluence[c], box.size, coarse, fluence[c]);
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < medium->cells; ++i) {
            const double x = (double)field->flux[c][0][i], y = (double)field->flux[c][1][i];
            const double z = (double)field->flux[c][2][i];
            if (!(sqrt(x * x + y * y + z * z) <= (double)field->fluence[c][i] * (1 + 1e-4)))
                fail_msg("cell %zu has more flux than fluence", i);
        }
    ty_discrete_light_set_destroy(context, &sources);
    ty_light_field_destroy(field);
    ty_grid_medium_destroy(medium);
}

enum { CELLS = COARSE * COARSE * COARSE };

/* Fluence of uncollided light by path tracing, in two runs, from whose difference its noise is known. */
static void trace_fluence(const ty_scene* scene, int32_t spp, double truth[2][3 * CELLS]) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    static const int32_t size[3] = {COARSE, COARSE, COARSE};
    double* all = new_numbers(3 * CELLS);
    for (int run = 0; run < 2; ++run) {
        ty_path_def def = ty_default_path_def();
        def.spp = spp;
        def.max_depth = 1;
        def.seed = (uint64_t)run;
        must(ty_scene_context(scene), ty_path_fluence(scene, &def, lower, upper, size, all, truth[run], NULL));
    }
    free(all);
}

/* Means of cells against those of path tracing. The cells next to a point light are left out: few samples carry most of
 * what path tracing finds there. Returns the largest relative RMSE. */
static double compare_cells(const char* name, const ty_scene* scene, int32_t longest, double truth[2][3 * CELLS],
                            double mean_bound, double rmse_bound) {
    float* fluence[3];
    for (int c = 0; c < 3; ++c) fluence[c] = calloc(CELLS, sizeof(float));
    double worst = 0;
    light_grid(scene, longest, fluence);
    for (int c = 0; c < 3; ++c) {
        double sum = 0, expected = 0, square = 0, noise = 0;
        for (int i = 0; i < CELLS; ++i) {
            const double a = truth[0][3 * i + c], b = truth[1][3 * i + c], value = (double)fluence[c][i];
            if (value > BRIGHT) continue;
            sum += value;
            expected += 0.5 * (a + b);
            square += pow(value - 0.5 * (a + b), 2);
            noise += 0.25 * (a - b) * (a - b);
        }
        const double ratio = sum / expected, scale = sqrt(CELLS) / expected;
        const double rmse = sqrt(fmax(0, square - noise)) * scale;
        printf("%-28s %c: mean ratio %.4f of %.3f, relative RMSE %.4f of %.3f (noise %.4f removed)\n", name, "RGB"[c],
               ratio, mean_bound, rmse, rmse_bound, sqrt(noise) * scale);
        if (!(fabs(ratio - 1) <= mean_bound)) fail_msg("%s: mean ratio %g", name, ratio);
        if (!(rmse <= rmse_bound)) fail_msg("%s: relative RMSE %g", name, rmse);
        worst = fmax(worst, rmse);
    }
    for (int c = 0; c < 3; ++c) free(fluence[c]);
    return worst;
}

static void compare(const char* name, ty_scene* scene, int32_t longest, int32_t spp, double mean_bound,
                    double rmse_bound) {
    static double truth[2][3 * CELLS];
    commit(scene);
    trace_fluence(scene, spp, truth);
    compare_cells(name, scene, longest, truth, mean_bound, rmse_bound);
    ty_scene_destroy(scene);
}

static void directional_light_is_right(void** state) {
    static const double ways[3][3] = {{0, -1, 0}, {0.3, -1, 0.5}, {-1, -0.2, 0.1}};
    for (int shadowed = 0; shadowed < 2; ++shadowed)
        for (int i = 0; i < 3; ++i) {
            ty_scene* scene = noise_scene(*state, shadowed ? SHADOWED : BARE, 2);
            ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 3);
            memcpy(sun.direction, ways[i], sizeof sun.direction);
            add_light(scene, &sun);
            compare(shadowed ? "directional, shadows" : "directional", scene, FINE, fewer(1024, 4), 0.025, 0.06);
        }
}

/* Twice as fine cells, at least half as far off. */
static void finer_cells_come_nearer(void** state) {
    static double truth[2][3 * CELLS];
    ty_scene* scene = noise_scene(*state, BARE, 2);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 3);
    set3(sun.direction, 0.3, -1, 0.5);
    add_light(scene, &sun);
    commit(scene);
    trace_fluence(scene, fewer(4096, 4), truth);
    const double fine = compare_cells("directional, 32^3", scene, FINE, truth, 0.02, 0.04);
    const double finer = compare_cells("directional, 64^3", scene, FINER, truth, 0.02, 0.04);
    ty_scene_destroy(scene);
    assert_true(finer < 0.6 * fine);
}

static void point_lights_are_right(void** state) {
    static const double places[3][3] = {{0.31, 0.4, -0.2}, {0.2, 1.2, 0.3}, {-3, 2, 4}};
    for (int i = 0; i < 3; i += in_full() ? 1 : 2) {
        ty_scene* scene = noise_scene(*state, SHADOWED, 2);
        ty_light_def lamp = light_of(TY_LIGHT_POINT, 3);
        memcpy(lamp.position, places[i], sizeof lamp.position);
        add_light(scene, &lamp);
        compare("point", scene, FINE, i == 0 ? NEAR_SPP : fewer(NEAR_SPP, 2), 0.025, 0.08);
    }
}

static void spot_lights_are_right(void** state) {
    ty_scene* scene = noise_scene(*state, SHADOWED, 2);
    ty_light_def lamp = light_of(TY_LIGHT_SPOT, 3);
    set3(lamp.position, -0.5, 1.5, 0.5);
    set3(lamp.direction, 0.2, -1, -0.1);
    lamp.cone = 60;
    add_light(scene, &lamp);
    compare("spot", scene, FINE, fewer(1024, 2), 0.035, 0.1);
}

static void area_lights_are_right(void** state) {
    ty_scene* scene = noise_scene(*state, SHADOWED, 2);
    ty_light_def light = light_of(TY_LIGHT_AREA, 3);
    set3(light.position, -1.2, 1.3, -0.5);
    set3(light.u, 1, 0, 0);
    set3(light.v, 0, 0, 1);
    add_light(scene, &light);
    compare("area", scene, FINE, fewer(1024, 2), 0.03, 0.05);
}

static void emissive_shapes_are_right(void** state) {
    ty_scene* scene = noise_scene(*state, SHADOWED, 2);
    const ty_shape_def ball = sphere_shape(0.6, -0.5, 0.5, 0.2, 0, 4);
    add_shape(scene, &ball);
    compare("glowing ball", scene, FINE, fewer(NEAR_SPP, 2), 0.03, 0.12);
}

static void emissive_meshes_are_right(void** state) {
    static const double low[3] = {0.3, 0.3, -0.6}, high[3] = {0.6, 0.5, -0.2};
    ty_scene* scene = noise_scene(*state, SHADOWED, 2);
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, low, high);
    ty_mesh_def def = made_def(&mesh);
    gray(def.material.emission, 2);
    must(*state, ty_scene_add_mesh(scene, &def));
    made_free(&mesh);
    compare("glowing mesh", scene, FINE, fewer(NEAR_SPP, 2), 0.03, 0.12);
}

static void environments_are_right(void** state) {
    for (int map = 0; map < 2; ++map) {
        ty_scene* scene = noise_scene(*state, SHADOWED, 2);
        ty_light_def light = light_of(TY_LIGHT_ENVIRONMENT, 0.7);
        ty_image* image = NULL;
        if (map) {
            must(*state, ty_image_create_rgb(*state, 32, 16, &image));
            for (int c = 0; c < 3; ++c)
                for (int i = 0; i < 32 * 16; ++i)
                    ty_image_plane(image, c)[i] = (float)(0.2 + (i / 32 < 5 ? 2 + c : 0) * (i % 32 < 10 ? 2 : 0.1));
            light.image = image;
        }
        add_light(scene, &light);
        ty_image_destroy(image);
        compare(map ? "environment, map" : "environment", scene, FINE, fewer(1024, 2), 0.03, 0.05);
    }
}

static void many_lights_add_up(void** state) {
    ty_scene* scene = noise_scene(*state, SHADOWED, 2);
    ty_medium_def ball = medium_sphere(0.5, 3, 1, 0);
    add_medium(scene, &ball);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 3), lamp = light_of(TY_LIGHT_POINT, 1);
    set3(sun.direction, 0.3, -1, 0.5);
    set3(lamp.position, 0.2, 1.2, 0.3);
    add_light(scene, &sun);
    add_light(scene, &lamp);
    compare("sun and lamp, a ball of fog", scene, FINE, fewer(1024, 2), 0.025, 0.08);
}

/* A ball in a tilted shell and another medium around it, with albedo and g that vary, under a slanting sun and a lamp:
 * what overlaps adds up, and of fields only extinction counts. */
static void shells_and_fields_are_right(void** state) {
    static const double center[3] = {0.1, -0.1, 0}, tilt[3] = {20, 30, 10}, scale[3] = {1, 1.3, 0.8};
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, (const double[3]){0, 0, 0}, 0.6, 32);
    ty_scene* scene = noise_scene(*state, SHADOWED, 1);
    ty_medium_def ball = medium_of(3, 1, 0);
    ball.bounds = TY_BOUNDS_SHELL;
    ball.transform = ty_affine_compose(center, tilt, scale);
    ball.scale = 0.7f;
    must(*state, made_shell(*state, &mesh, &ball.shell));
    ty_medium_def fog = medium_cube(0.6, 0.5, 0.5, 0);
    fog.box_max[0] = 1;
    ty_noise_def noise = ty_default_noise_def();
    noise.size[0] = noise.size[1] = noise.size[2] = 16;
    must(*state, ty_grid_create_noise(*state, &noise, &fog.g_grid));
    for (int c = 0; c < 3; ++c) fog.albedo_grid[c] = fog.g_grid;
    add_medium(scene, &ball);
    add_medium(scene, &fog);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 3), lamp = light_of(TY_LIGHT_POINT, 1);
    set3(sun.direction, 0.3, -1, 0.5);
    set3(lamp.position, 0.2, 1.2, 0.3);
    add_light(scene, &sun);
    add_light(scene, &lamp);
    compare("shell, fields, overlap", scene, FINE, fewer(1024, 2), 0.025, 0.08);
    ty_closed_mesh_release(ball.shell);
    ty_grid_release(fog.g_grid);
    made_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directional_light_is_right), cmocka_unit_test(finer_cells_come_nearer),
        cmocka_unit_test(point_lights_are_right),     cmocka_unit_test(spot_lights_are_right),
        cmocka_unit_test(area_lights_are_right),      cmocka_unit_test(emissive_shapes_are_right),
        cmocka_unit_test(emissive_meshes_are_right),  cmocka_unit_test(environments_are_right),
        cmocka_unit_test(many_lights_add_up),         cmocka_unit_test(shells_and_fields_are_right),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
