/* Channels beside the image: what they add up to, and each against what it must be. */
#include "truth_cases.h"
#include "triangle_maker.h"

enum { SIDE = 16 };

static const char* const color_names[3] = {"R", "G", "B"};
static const char* const single_names[3] = {"single.R", "single.G", "single.B"};
static const char* const multiple_names[3] = {"multiple.R", "multiple.G", "multiple.B"};

static ty_image* render_aovs(const ty_scene* scene, int32_t spp, int32_t max_depth, uint32_t aovs,
                             const int32_t* crop) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.width = def.height = SIDE;
    def.max_depth = max_depth;
    def.aovs = aovs;
    if (crop != NULL) memcpy(def.crop, crop, sizeof def.crop);
    ty_image* image = NULL;
    must(ty_scene_context(scene), ty_path_render(scene, &def, &image, NULL));
    return image;
}

static const float* plane(const ty_image* image, const char* name) {
    const float* values = ty_image_plane_const(image, ty_image_find_channel(image, name));
    if (values == NULL) fail_msg("there is no channel %s", name);
    return values;
}

static estimate plane_mean(const ty_image* image, const char* name) {
    const int64_t count = (int64_t)ty_image_width(image) * ty_image_height(image);
    double values[SIDE * SIDE];
    for (int64_t i = 0; i < count; ++i) values[i] = (double)plane(image, name)[i];
    return estimate_of(values, count, 1);
}

/* Fog of every kind, which glows if asked to, over a floor, with a lamp, a sun, a sky and something that glows. */
static ty_scene* busy_scene(ty_context* context, double glow) {
    static const double center[3] = {0, -1, 0}, u[3] = {0, 0, 1}, v[3] = {1, 0, 0};
    static const double low[3] = {0.3, -1, -0.6}, high[3] = {0.8, -0.2, 0};
    ty_scene* scene = new_scene(context);
    ty_medium_def fog = medium_cube(1, 0.5, 0.2, 0.4), cloud = medium_cube(0.6, 3, 0.3, 0);
    rgb(fog.sigma_s, 0.3, 0.5, 0.9);
    gray(fog.emission, glow);
    ty_noise_def noise = ty_default_noise_def();
    noise.size[0] = noise.size[1] = noise.size[2] = 24;
    must(context, ty_grid_create_noise(context, &noise, &cloud.density_grid));
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, low, high);
    ty_mesh_def box = made_def(&mesh);
    gray(box.material.emission, 0.5);
    ty_light_def lamp = light_of(TY_LIGHT_POINT, 1), sun = light_of(TY_LIGHT_DIRECTIONAL, 2);
    const ty_light_def sky = light_of(TY_LIGHT_ENVIRONMENT, 0.2);
    set3(lamp.position, -0.5, 0.7, 0.5);
    const ty_shape_def floor = square_shape(center, u, v, 2, 0.6);
    add_medium(scene, &fog);
    add_medium(scene, &cloud);
    add_shape(scene, &floor);
    must(context, ty_scene_add_mesh(scene, &box));
    add_light(scene, &lamp);
    add_light(scene, &sun);
    add_light(scene, &sky);
    set_camera(scene, 0.5, 1.5, 4, 40);
    commit(scene);
    ty_grid_release(cloud.density_grid);
    made_free(&mesh);
    return scene;
}

/* Asking for channels changes no pixel; what scattered is part of the whole, and all of it where nothing else shines.
 */
static void single_and_multiple_add_up(void** state) {
    ty_scene* scene = busy_scene(*state, 0.1);
    ty_image* image = render_aovs(scene, 64, 0, TY_AOV_ALL, NULL);
    ty_image* plain = render_aovs(scene, 64, 0, 0, NULL);
    double scattered = 0, all = 0;
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(plane(image, color_names[c]), plane(plain, color_names[c]), SIDE * SIDE * sizeof(float));
        for (int i = 0; i < SIDE * SIDE; ++i) {
            const double single = (double)plane(image, single_names[c])[i],
                         multiple = (double)plane(image, multiple_names[c])[i];
            const double total = (double)plane(image, color_names[c])[i];
            assert_true(single >= 0 && multiple >= 0 && single + multiple <= total * (1 + 1e-6));
            scattered += single + multiple;
            all += total;
        }
    }
    assert_true(scattered > 0.1 * all && scattered < 0.9 * all);
    ty_image_destroy(image);
    ty_image_destroy(plain);
    ty_scene_destroy(scene);
    scene = new_scene(*state);
    const ty_medium_def fog = medium_cube(1, 1, 0.1, 0.3);
    const ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 2);
    add_medium(scene, &fog);
    add_light(scene, &sun);
    set_camera(scene, 0.5, 1.5, 4, 40);
    commit(scene);
    image = render_aovs(scene, 64, 0, TY_AOV_SINGLE | TY_AOV_MULTIPLE, NULL);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const double sum = (double)plane(image, "single.R")[i] + (double)plane(image, "multiple.R")[i];
        const double total = (double)plane(image, "R")[i];
        assert_true(fabs(sum - total) <= 3e-7 * total);
    }
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* ---- what no medium scattered ---- */

enum { SEEDS = 24 };

/* The sum over a quarter of the image of a channel without what scattered. */
static double quarter_sum(const ty_image* image, int c, int quarter) {
    const int left = quarter % 2 * SIDE / 2, top = quarter / 2 * SIDE / 2;
    double sum = 0;
    for (int y = top; y < top + SIDE / 2; ++y)
        for (int x = left; x < left + SIDE / 2; ++x) {
            const int i = y * SIDE + x;
            sum += (double)plane(image, color_names[c])[i] - (double)plane(image, single_names[c])[i] -
                   (double)plane(image, multiple_names[c])[i];
        }
    return sum;
}

/* Quarters of the image by seeds. */
static void quarter_estimates(const ty_scene* scene, bool unscattered, int32_t spp, estimate estimates[12]) {
    double sum[12] = {0}, square[12] = {0};
    for (uint64_t seed = 0; seed < SEEDS; ++seed) {
        ty_path_def def = ty_default_path_def();
        def.spp = spp;
        def.seed = seed;
        def.width = def.height = SIDE;
        def.unscattered = unscattered;
        def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE;
        ty_image* image = NULL;
        must(ty_scene_context(scene), ty_path_render(scene, &def, &image, NULL));
        for (int i = 0; i < 12; ++i) {
            const double value = quarter_sum(image, i / 4, i % 4);
            sum[i] += value;
            square[i] += value * value;
        }
        ty_image_destroy(image);
    }
    for (int i = 0; i < 12; ++i) {
        const double mean = sum[i] / SEEDS;
        estimates[i] = (estimate){mean, sqrt(fmax(0, square[i] / SEEDS - mean * mean) / (SEEDS - 1))};
    }
}

/* Light that media neither scatter nor send, rendered alone, is what an ordinary render has of it. */
static void unscattered_light_is_the_rest(void** state) {
    ty_scene *scene = busy_scene(*state, 0), *glowing = busy_scene(*state, 0.1);
    estimate expected[12], alone[12], dark[12];
    quarter_estimates(scene, false, 512, expected);
    quarter_estimates(scene, true, 256, alone);
    quarter_estimates(glowing, true, 256, dark);
    for (int i = 0; i < 12; ++i) {
        const estimate both = {alone[i].mean, hypot(alone[i].error, expected[i].error)};
        assert_close("unscattered, a quarter", both, expected[i].mean, 0.004);
        assert_true(dark[i].mean == alone[i].mean);
    }
    ty_scene_destroy(scene);
    ty_scene_destroy(glowing);
}

/* ---- single scattering ---- */

/* A cube of half side 1 under a sun of 2 from above, seen along -z at height y. */
static double sunlit(double y, double sigma_s, double sigma_t, double g) {
    return 2 * sigma_s * henyey_greenstein(0, g) * exp(-sigma_t * (1 - y)) * -expm1(-2 * sigma_t) / sigma_t;
}

static void single_scattering_has_its_closed_form(void** state) {
    ty_scene* scene = new_scene(*state);
    const ty_medium_def cube = medium_cube(1, 1, 0.5, 0.4);
    const ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 2);
    add_medium(scene, &cube);
    add_light(scene, &sun);
    set_camera(scene, 0, 0, 4, 0.01); /* all pixels see the same */
    commit(scene);
    const double expected = sunlit(0, 1, 1.5, 0.4);
    for (int32_t max_depth = 0; max_depth < 2; ++max_depth) {
        ty_image* image = render_aovs(scene, 2048, max_depth, TY_AOV_SINGLE | TY_AOV_MULTIPLE, NULL);
        assert_close("single scattering", plane_mean(image, "single.R"), expected, 0.004);
        if (max_depth == 1) {
            assert_close("all light of depth 1", plane_mean(image, "R"), expected, 0.004);
            assert_true(plane_mean(image, "multiple.R").mean == 0);
        } else {
            assert_true(plane_mean(image, "multiple.R").mean > 0.05 * expected);
        }
        ty_image_destroy(image);
    }
    ty_scene_destroy(scene);
}

/* ---- transmittance and albedo ---- */

static void transmittance_is_exact(void** state) {
    static const double sigma[3] = {0.3, 0.9, 2.5};
    for (int gridded = 0; gridded < 2; ++gridded) {
        ty_scene* scene = new_scene(*state);
        ty_medium_def cube = medium_cube(1, 0, 0, 0.4);
        for (int c = 0; c < 3; ++c) {
            cube.sigma_s[c] = (float)(sigma[c] * 0.8);
            cube.sigma_a[c] = (float)(sigma[c] * 0.2);
        }
        float values[64];
        for (int i = 0; i < 64; ++i) values[i] = i % 4 < 2 ? 0.5f : 1.5f; /* along x; the mean along z is their own */
        ty_grid_def def = ty_default_grid_def();
        def.size[0] = def.size[1] = def.size[2] = 4;
        def.values = values;
        if (gridded) must(*state, ty_grid_create(*state, &def, &cube.density_grid));
        add_medium(scene, &cube);
        set_camera(scene, gridded ? -0.75 : 0.2, 0, 4, 0.01);
        ty_camera_def camera = ty_scene_camera(scene);
        camera.target[0] = camera.position[0];
        must(*state, ty_scene_set_camera(scene, &camera));
        commit(scene);
        ty_image* image = render_aovs(scene, gridded ? 512 : 64, 0, TY_AOV_TRANSMITTANCE | TY_AOV_ALBEDO, NULL);
        static const char* const names[3] = {"transmittance.R", "transmittance.G", "transmittance.B"};
        static const char* const albedos[3] = {"albedo.R", "albedo.G", "albedo.B"};
        for (int c = 0; c < 3; ++c) {
            const double depth = 2 * sigma[c] * (gridded ? 0.5 : 1), through = exp(-depth);
            assert_close("transmittance", plane_mean(image, names[c]), through, gridded ? 0.006 : 2e-5);
            if (!gridded) continue;
            assert_close("volume albedo", plane_mean(image, albedos[c]), 0.8 * (1 - through), 0.012);
        }
        ty_image_destroy(image);
        ty_scene_destroy(scene);
        ty_grid_release(cube.density_grid);
    }
}

/* Light that neither passes nor scatters is absorbed: nothing, where the albedo is 1. */
static void albedo_conserves_energy(void** state) {
    for (int absorbing = 0; absorbing < 2; ++absorbing) {
        ty_scene* scene = new_scene(*state);
        ty_medium_def cloud = medium_cube(1, 2, absorbing ? 1 : 0, 0.4);
        ty_noise_def noise = ty_default_noise_def();
        noise.size[0] = noise.size[1] = noise.size[2] = 24;
        noise.kind = TY_NOISE_FBM;
        must(*state, ty_grid_create_noise(*state, &noise, &cloud.density_grid));
        add_medium(scene, &cloud);
        set_camera(scene, 0.5, 1.5, 4, 25);
        commit(scene);
        ty_image* image = render_aovs(scene, 1024, 0, TY_AOV_TRANSMITTANCE | TY_AOV_ALBEDO, NULL);
        const estimate passes = plane_mean(image, "transmittance.G"), scatters = plane_mean(image, "albedo.G");
        const estimate sum = {passes.mean + scatters.mean, 0};
        assert_true(passes.mean > 0.02 && passes.mean < 0.98);
        assert_close("passed or scattered", sum, absorbing ? 1 - (1 - passes.mean) / 3 : 1, 0.004);
        ty_image_destroy(image);
        ty_scene_destroy(scene);
        ty_grid_release(cloud.density_grid);
    }
}

/* ---- depth and normal ---- */

/* A ball, a board or a mesh of either, seen along the middle pixels' rays. */
static void check_first_surface(ty_context* context, bool ball, bool meshed) {
    static const double center[3] = {0.1, 0.2, -0.3}, u[3] = {0.8, 0, -0.6}, v[3] = {0, 1, 0};
    ty_scene* scene = new_scene(context);
    const ty_shape_def board = square_shape(center, u, v, 0.7, 0.5), sphere = sphere_shape(0.1, 0.2, -0.3, 0.7, 0.5, 0);
    made_mesh mesh = made_nothing();
    if (ball)
        made_add_sphere(&mesh, center, 0.7, 40);
    else
        made_add_quad(&mesh, board.origin, board.u, board.v);
    ty_mesh_def def = made_def(&mesh);
    if (ball) def.normals = mesh.normals;
    if (meshed)
        must(context, ty_scene_add_mesh(scene, &def));
    else
        add_shape(scene, ball ? &sphere : &board);
    const ty_medium_def fog = medium_cube(2, 1, 1, 0);
    add_medium(scene, &fog);
    set_camera(scene, 0, 0, 5, 30);
    commit(scene);
    ty_image* image = render_aovs(scene, 64, 0, TY_AOV_DEPTH | TY_AOV_NORMAL, NULL);
    int met = 0, missed = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const double scale = 2 * tan(pi / 12) / SIDE;
        double d[3] = {(i % SIDE + 0.5 - SIDE / 2) * scale, (SIDE / 2 - i / SIDE - 0.5) * scale, -1};
        normalize3(d);
        const double o[3] = {-center[0], -center[1], 5 - center[2]}, n[3] = {0.6, 0, 0.8};
        const double along = dot3(o, d), square = along * along - dot3(o, o) + 0.49;
        const double distance = ball ? -along - sqrt(fmax(0, square)) : -dot3(o, n) / dot3(d, n);
        double at[3];
        for (int a = 0; a < 3; ++a) at[a] = o[a] + distance * d[a];
        const double across = at[0] * u[0] + at[2] * u[2];
        const double inside = ball ? 0.7 - sqrt(fmax(0, 0.49 - square)) : 0.7 - fmax(fabs(across), fabs(at[1]));
        const float* normal[3] = {plane(image, "normal.X"), plane(image, "normal.Y"), plane(image, "normal.Z")};
        const float depth = plane(image, "depth.Z")[i];
        if (inside < -0.15) {
            ++missed;
            assert_true(depth == 0 && normal[0][i] == 0 && normal[1][i] == 0 && normal[2][i] == 0);
        }
        if (inside < 0.25) continue;
        ++met;
        if (!(fabs((double)depth - distance) < 0.02)) fail_msg("depth %g, not %g", (double)depth, distance);
        for (int a = 0; a < 3; ++a) {
            const double expected = ball ? at[a] / 0.7 : n[a];
            if (!(fabs((double)normal[a][i] - expected) < (ball ? 0.03 : 1e-5)))
                fail_msg("pixel %d: normal %d is %g, not %g", i, a, (double)normal[a][i], expected);
        }
    }
    assert_true(met > 5 && missed > 50);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

static void the_first_surface_is_told(void** state) {
    for (int kind = 0; kind < 4; ++kind) check_first_surface(*state, kind & 1, kind & 2);
}

/* ---- crops ---- */

static void crops_are_parts_of_the_image(void** state) {
    static const int32_t crop[4] = {5, 3, 7, 9};
    ty_scene* scene = busy_scene(*state, 0.1);
    ty_image* whole = render_aovs(scene, 7, 0, TY_AOV_ALL, NULL);
    ty_image* part = render_aovs(scene, 7, 0, TY_AOV_ALL, crop);
    assert_int_equal(ty_image_width(part), 7);
    assert_int_equal(ty_image_channel_count(part), ty_image_channel_count(whole));
    for (int c = 0; c < ty_image_channel_count(whole); ++c)
        for (int y = 0; y < 9; ++y)
            assert_memory_equal(ty_image_plane_const(part, c) + 7 * y,
                                ty_image_plane_const(whole, c) + SIDE * (y + 3) + 5, 7 * sizeof(float));
    ty_image_destroy(whole);
    ty_image_destroy(part);
    ty_scene_destroy(scene);
}

/* ---- a hundred lamps ---- */

enum { LAMPS = 100, GROUPS = 10 };

/* Lamps of a group, or all of them, under the ceiling of a foggy room. */
static ty_scene* lamp_room(ty_context* context, int group) {
    static const double low[3] = {-2, -1, -2}, high[3] = {2, 1, 2};
    ty_scene* scene = new_scene(context);
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, low, high);
    made_turn(&mesh, 0);
    ty_mesh_def def = made_def(&mesh);
    must(context, ty_scene_add_mesh(scene, &def));
    ty_medium_def fog = medium_cube(1, 0.15, 0.05, 0.3);
    for (int a = 0; a < 3; ++a) {
        fog.box_min[a] = low[a];
        fog.box_max[a] = high[a];
    }
    add_medium(scene, &fog);
    for (int i = 0; i < LAMPS; ++i) {
        if (group >= 0 && i % GROUPS != group) continue;
        ty_light_def lamp = light_of(i % 2 ? TY_LIGHT_SPOT : TY_LIGHT_POINT, i % 2 ? 0.6 : 0.3);
        set3(lamp.position, -1.8 + 0.36 * (i % 10), 0.5, -1.8 + 0.36 * (i / 10));
        lamp.cone = 120;
        add_light(scene, &lamp);
    }
    set_camera(scene, 0.1, 0.1, 1.8, 70);
    commit(scene);
    made_free(&mesh);
    return scene;
}

static estimate room_mean(ty_context* context, int group, int32_t spp) {
    ty_scene* scene = lamp_room(context, group);
    ty_image* image = render_aovs(scene, spp, 0, TY_AOV_VARIANCE, NULL);
    const estimate mean = image_mean(image, 0);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    return mean;
}

static void a_room_of_lights_adds_up(void** state) {
    estimate sum = {0, 0};
    for (int group = 0; group < GROUPS; ++group) {
        const estimate part = room_mean(*state, group, fewer(512, 2));
        sum.mean += part.mean;
        sum.error = hypot(sum.error, part.error);
    }
    const estimate all = room_mean(*state, -1, fewer(2048, 2));
    sum.error = hypot(sum.error, all.error);
    assert_close("a hundred lamps in ten rooms", sum, all.mean, 0.01);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(single_and_multiple_add_up), cmocka_unit_test(single_scattering_has_its_closed_form),
        cmocka_unit_test(transmittance_is_exact),     cmocka_unit_test(albedo_conserves_energy),
        cmocka_unit_test(the_first_surface_is_told),  cmocka_unit_test(crops_are_parts_of_the_image),
        cmocka_unit_test(a_room_of_lights_adds_up),   cmocka_unit_test(unscattered_light_is_the_rest),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
