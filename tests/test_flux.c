/* Fluxes by columns: wrong places, closed forms, a published slab, the balance of energy. */
#include "fog.h"

#include <math.h>
#include <stdio.h>

enum { SPP = 4096 };

/* An infinite layer 1 m thick, as a periodic box, over a ground. zenith: of the sun, degrees; its irradiance on a
 * horizontal plane is 1. */
static ty_scene* layer_scene(ty_context* context, const ty_medium_def* layer, double zenith, double ground) {
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Z, &scene), TY_OK);
    ty_light_def sun = ty_default_light_def();
    const double angle = zenith * 3.14159265358979 / 180;
    set3(sun.direction, 0.6 * sin(angle), 0.8 * sin(angle), -cos(angle));
    for (int c = 0; c < 3; ++c) sun.color[c] = (float)(1 / cos(angle));
    ty_shape_def floor = ty_default_shape_def();
    set3(floor.origin, -9, -9, -0.5);
    set3(floor.u, 18, 0, 0);
    set3(floor.v, 0, 18, 0);
    set3f(floor.albedo, (float)ground, (float)ground, (float)ground);
    ty_periodic_def def = ty_default_periodic_def();
    def.axes[0] = def.axes[1] = true;
    assert_int_equal(ty_scene_add_medium(scene, layer), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    if (ground > 0) assert_int_equal(ty_scene_add_shape(scene, &floor), TY_OK);
    assert_int_equal(ty_scene_set_periodic(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static ty_medium_def layer_of(float sigma_s, float sigma_a, float g) {
    const double lower[3] = {0, 0, 0}, upper[3] = {0.7, 0.4, 1};
    ty_medium_def layer = box_medium(lower, upper, sigma_s, sigma_a);
    for (int c = 0; c < 3; ++c) layer.g[c] = g;
    return layer;
}

static ty_flux* flux_of(const ty_scene* scene, const double* levels, int32_t count, int32_t columns, int32_t spp) {
    ty_path_def path = ty_default_path_def();
    ty_flux_def def = ty_default_flux_def();
    ty_flux* flux = NULL;
    path.spp = spp;
    def.levels = levels;
    def.level_count = count;
    def.columns[0] = columns;
    const ty_result result = ty_path_flux(scene, &path, &def, &flux, NULL);
    if (result != TY_OK) fail_msg("%s", ty_take_error(ty_scene_context(scene)));
    return flux;
}

/* Voxels of random density. */
static ty_grid* uneven_grid(ty_context* context) {
    ty_grid_def def = ty_default_grid_def();
    float values[8 * 6 * 4];
    uint64_t random = 5;
    for (int i = 0; i < 8 * 6 * 4; ++i) values[i] = (float)pow(uniform(&random), 3) * 4;
    def.size[0] = 8;
    def.size[1] = 6;
    def.size[2] = 4;
    def.values = values;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    return grid;
}

typedef struct number {
    double mean, error;
} number;

static number mean_of(const ty_flux* flux, ty_flux_quantity quantity, int32_t index) {
    double mean[3], error[3];
    ty_flux_mean(flux, quantity, index, mean, error);
    return (number){mean[1], error[1]};
}

/* Within four standard errors, which are themselves below `noise`, and what a level is above its height (1e-5). */
static void assert_is(const char* name, number n, double expected, double noise) {
    printf("%-32s %.5f +- %.5f, expected %.5f\n", name, n.mean, n.error, expected);
    if (!(fabs(n.mean - expected) <= 4 * n.error + 3e-5)) fail_msg("%s: %g, not %g", name, n.mean, expected);
    if (!(n.error <= noise)) fail_msg("%s: the error is %g", name, n.error);
}

static void wrong_places_are_refused(void** state) {
    static const double levels[2] = {0, 1}, falling[2] = {1, 0}, wild[1] = {INFINITY};
    static const ty_flux_view level_view = {90, 0};
    const ty_medium_def layer = layer_of(1, 0, 0);
    ty_scene* scene = layer_scene(*state, &layer, 0, 0);
    const ty_path_def path = small_def(1);
    for (int i = 0; i < 6; ++i) {
        static const char* const words[] = {"flux.level_count",     "flux.levels[1]",  "flux.levels[0]",
                                            "flux.views[0].zenith", "flux.columns[1]", "ty_default_flux_def"};
        ty_flux_def def = ty_default_flux_def();
        ty_flux* flux = NULL;
        def.levels = i == 1 ? falling : i == 2 ? wild : levels;
        def.level_count = i == 0 ? 0 : i == 2 ? 1 : 2;
        if (i == 3) def.views = &level_view;
        def.view_count = i == 3;
        if (i == 4) def.columns[1] = 0;
        if (i == 5) def.cookie = 0;
        assert_int_equal(ty_path_flux(scene, &path, &def, &flux, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, words[i]);
        assert_null(flux);
    }
    ty_scene_destroy(scene);
}

/* Without scattering all light is direct, by Beer's law, and what is absorbed is what is gone. */
static void an_absorbing_layer_follows_beers_law(void** state) {
    static const double levels[3] = {0, 0.25, 1};
    const ty_medium_def layer = layer_of(0, 1.5f, 0);
    ty_scene* scene = layer_scene(*state, &layer, 60, 0);
    ty_flux* flux = flux_of(scene, levels, 3, 3, SPP);
    for (int i = 0; i < 3; ++i) {
        assert_is("direct", mean_of(flux, TY_FLUX_DOWN_DIRECT, i), exp(-1.5 * (1 - levels[i]) / 0.5), 1e-3);
        assert_is("diffuse", mean_of(flux, TY_FLUX_DOWN_DIFFUSE, i), 0, 0);
        assert_is("up", mean_of(flux, TY_FLUX_UP, i), 0, 0);
    }
    assert_is("absorbed", mean_of(flux, TY_FLUX_ABSORBED, 0), 1 - exp(-3), 8e-3);
    assert_null(ty_flux_values(flux, TY_FLUX_UP, 3));
    assert_null(ty_flux_values(flux, TY_FLUX_RADIANCE, 0));
    ty_flux_destroy(flux);
    ty_scene_destroy(scene);
}

/* The layer under a sky of radiance 1 from above: `rows` rows of pixels, or 0: a constant one, from below, too. */
static ty_scene* sky_scene(ty_context* context, const ty_medium_def* layer, int32_t rows) {
    ty_scene* scene = NULL;
    ty_image* image = NULL;
    ty_light_def sky = sky_light(1, 1, 1);
    ty_periodic_def def = ty_default_periodic_def();
    def.axes[0] = def.axes[1] = true;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Z, &scene), TY_OK);
    assert_int_equal(ty_scene_add_medium(scene, layer), TY_OK);
    if (rows > 0) {
        assert_int_equal(ty_image_create_rgb(context, rows, rows, &image), TY_OK);
        for (int c = 0; c < 3; ++c)
            for (int32_t i = 0; i < rows * rows; ++i) ty_image_plane(image, c)[i] = i < rows * rows / 2 ? 1 : 0;
        sky.image = image;
    }
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_set_periodic(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_image_destroy(image);
    return scene;
}

/* Light of a sky is direct: an absorbing layer of optical thickness 1 passes 2 pi E_3(1) of pi. A constant sky is not
 * sampled as a light, and one of an image is; its horizon is one row of pixels wide. */
static void light_of_the_sky_is_direct(void** state) {
    static const double levels[2] = {0, 1};
    const double pi = 3.14159265358979, passed = 2 * pi * 0.1096919671977;
    const ty_medium_def layer = layer_of(0, 1, 0);
    for (int32_t rows = 0; rows <= 256; rows += 256) {
        ty_scene* scene = sky_scene(*state, &layer, rows);
        ty_flux* flux = flux_of(scene, levels, 2, 1, SPP);
        assert_is("direct above", mean_of(flux, TY_FLUX_DOWN_DIRECT, 1), pi, rows > 0 ? 1.5e-2 : 1e-6);
        assert_is("direct below", mean_of(flux, TY_FLUX_DOWN_DIRECT, 0), passed, 1e-2);
        assert_is("up above", mean_of(flux, TY_FLUX_UP, 1), rows > 0 ? 0 : passed, 2.5e-2);
        assert_is("up below", mean_of(flux, TY_FLUX_UP, 0), rows > 0 ? 0 : pi, 1e-2);
        for (int i = 0; i < 2; ++i) assert_is("diffuse", mean_of(flux, TY_FLUX_DOWN_DIFFUSE, i), 0, 0);
        ty_flux_destroy(flux);
        ty_scene_destroy(scene);
    }
}

/* Light that a layer emits is diffuse: pi (1 - 2 E_3(1)) on both sides, also where its density is a grid. */
static void emission_of_media_is_diffuse(void** state) {
    static const double levels[2] = {0, 1};
    static const float ones[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    const double expected = 3.14159265358979 * (1 - 2 * 0.1096919671977);
    ty_grid_def def = ty_default_grid_def();
    ty_grid* grid = NULL;
    for (int a = 0; a < 3; ++a) def.size[a] = 2;
    def.values = ones;
    assert_int_equal(ty_grid_create(*state, &def, &grid), TY_OK);
    for (int gridded = 0; gridded < 2; ++gridded) {
        ty_medium_def layer = layer_of(0, 1, 0);
        set3f(layer.emission, 1, 1, 1);
        layer.density_grid = gridded == 1 ? grid : NULL;
        ty_scene* scene = layer_scene(*state, &layer, 0, 0);
        ty_flux* flux = flux_of(scene, levels, 2, 1, SPP);
        assert_is("diffuse below", mean_of(flux, TY_FLUX_DOWN_DIFFUSE, 0), expected, 3e-2);
        assert_is("diffuse above", mean_of(flux, TY_FLUX_DOWN_DIFFUSE, 1), 0, 1e-4);
        assert_is("up above", mean_of(flux, TY_FLUX_UP, 1), expected, 3e-2);
        assert_is("direct below", mean_of(flux, TY_FLUX_DOWN_DIRECT, 0), exp(-1), 1e-2);
        ty_flux_destroy(flux);
        ty_scene_destroy(scene);
    }
    ty_grid_release(grid);
}

/* A periodic box is a slab: van de Hulst 1980, as MCML's paper cites it: diffuse reflectance 0.09739 and total
 * transmittance 0.66096 for g = 0.75, albedo 0.9 and optical thickness 2 at normal incidence. */
static void a_layer_has_published_fluxes(void** state) {
    static const double levels[2] = {0, 1};
    const ty_medium_def layer = layer_of(1.8f, 0.2f, 0.75f);
    ty_scene* scene = layer_scene(*state, &layer, 0, 0);
    ty_flux* flux = flux_of(scene, levels, 2, 1, 16 * SPP);
    const number diffuse = mean_of(flux, TY_FLUX_DOWN_DIFFUSE, 0), direct = mean_of(flux, TY_FLUX_DOWN_DIRECT, 0);
    assert_is("reflectance", mean_of(flux, TY_FLUX_UP, 1), 0.09739, 1.5e-3);
    assert_is("transmittance", (number){diffuse.mean + direct.mean, hypot(diffuse.error, direct.error)}, 0.66096, 4e-3);
    assert_is("absorptance", mean_of(flux, TY_FLUX_ABSORBED, 0), 1 - 0.09739 - 0.66096, 2e-3);
    ty_flux_destroy(flux);
    ty_scene_destroy(scene);
}

static ty_flux* solved_flux(const ty_scene* scene, const double* levels, int32_t count, int32_t columns,
                            int32_t resolution, ty_dom_stats* stats) {
    ty_dom_def dom = ty_default_dom_def();
    ty_flux_def def = ty_default_flux_def();
    ty_flux* flux = NULL;
    dom.resolution = resolution;
    dom.tolerance = 1e-4;
    def.levels = levels;
    def.level_count = count;
    def.columns[0] = columns;
    const ty_result result = ty_dom_flux(scene, &dom, &def, &flux, stats);
    if (result != TY_OK) fail_msg("%s", ty_take_error(ty_scene_context(scene)));
    return flux;
}

/* The sum of the light that goes out through the outer of two levels, and is absorbed. */
static double sum_of(const ty_flux* flux) {
    return mean_of(flux, TY_FLUX_UP, 1).mean + mean_of(flux, TY_FLUX_DOWN_DIFFUSE, 0).mean +
           mean_of(flux, TY_FLUX_DOWN_DIRECT, 0).mean + mean_of(flux, TY_FLUX_ABSORBED, 0).mean;
}

static void assert_near(const char* name, double value, double expected, double bound) {
    printf("%-32s %.5f, expected %.5f\n", name, value, expected);
    if (!(fabs(value - expected) <= bound)) fail_msg("%s: %g, not %g", name, value, expected);
}

/* The same layer by ordinates: 0.3 % and 0.05 % off, in balance to 2e-5, and even along x to 1.1e-4, which is the
 * tolerance of the solve. */
static void dom_solves_the_layer(void** state) {
    static const double levels[2] = {0, 1};
    const ty_medium_def layer = layer_of(1.8f, 0.2f, 0.75f);
    ty_scene* scene = layer_scene(*state, &layer, 0, 0);
    ty_dom_stats stats = ty_default_dom_stats();
    ty_flux* flux = solved_flux(scene, levels, 2, 3, 24, &stats);
    const double* up = ty_flux_values(flux, TY_FLUX_UP, 1);
    const double down = mean_of(flux, TY_FLUX_DOWN_DIFFUSE, 0).mean + mean_of(flux, TY_FLUX_DOWN_DIRECT, 0).mean;
    printf("%d sweeps\n", (int)stats.sweeps[0]);
    assert_true(stats.converged);
    assert_near("reflectance", mean_of(flux, TY_FLUX_UP, 1).mean, 0.09739, 0.006 * 0.09739);
    assert_near("transmittance", down, 0.66096, 0.002 * 0.66096);
    assert_near("direct", mean_of(flux, TY_FLUX_DOWN_DIRECT, 0).mean, exp(-2), 1e-5);
    assert_near("sum", sum_of(flux), 1, 1e-4);
    for (int i = 1; i < 3; ++i) assert_near("column", up[3 * i], up[0], 3e-4 * up[0]);
    ty_flux_destroy(flux);
    ty_scene_destroy(scene);
}

static void dom_refuses_what_it_leaves_out(void** state) {
    static const double levels[1] = {0};
    static const ty_flux_view view = {0, 0};
    const ty_medium_def layer = layer_of(1, 0, 0);
    ty_scene *ground = layer_scene(*state, &layer, 0, 0.5), *open = make_scene(*state);
    assert_int_equal(ty_scene_add_medium(open, &layer), TY_OK);
    assert_int_equal(ty_scene_commit(open), TY_OK);
    const ty_dom_def dom = ty_default_dom_def();
    ty_flux_def def = ty_default_flux_def();
    ty_flux* flux = NULL;
    ty_image* image = NULL;
    def.levels = levels;
    def.level_count = 1;
    assert_int_equal(ty_dom_flux(ground, &dom, &def, &flux, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "dom does without surfaces");
    assert_int_equal(ty_dom_flux(open, &dom, &def, &flux, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "repeat along both horizontal axes");
    def.views = &view;
    def.view_count = 1;
    assert_int_equal(ty_dom_flux(ground, &dom, &def, &flux, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "flux.views");
    assert_null(flux);
    assert_int_equal(ty_dom_render(ground, &dom, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "dom takes no periodic scenes");
    ty_scene_destroy(open);
    ty_scene_destroy(ground);
}

/* Voxels under a slanted sun: with the means of path tracing, and in balance. */
static void dom_solves_a_cloud(void** state) {
    static const double levels[2] = {0, 1};
    ty_medium_def layer = layer_of(2, 0.1f, 0.85f);
    ty_grid* grid = uneven_grid(*state);
    layer.density_grid = grid;
    ty_scene* scene = layer_scene(*state, &layer, 50, 0);
    ty_dom_stats stats = ty_default_dom_stats();
    ty_flux* flux = solved_flux(scene, levels, 2, 2, 32, &stats);
    ty_flux* traced = flux_of(scene, levels, 2, 2, 4 * SPP);
    printf("%d sweeps\n", (int)stats.sweeps[0]);
    assert_true(stats.converged);
    assert_near("sum", sum_of(flux), 1, 1e-4);
    for (int q = TY_FLUX_UP; q <= TY_FLUX_ABSORBED; ++q) {
        const number expected = mean_of(traced, q, q == TY_FLUX_UP ? 1 : 0);
        assert_near("dom", mean_of(flux, q, q == TY_FLUX_UP ? 1 : 0).mean, expected.mean,
                    0.03 * expected.mean + 4 * expected.error);
    }
    ty_flux_destroy(traced);
    ty_flux_destroy(flux);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

/* Everything that comes in goes up, into the ground, or into the media: each is estimated by paths of its own. */
static void energy_is_in_balance(void** state) {
    static const double levels[2] = {-0.5, 1};
    ty_medium_def layer = layer_of(2, 0.1f, 0.85f);
    ty_grid* grid = uneven_grid(*state);
    layer.density_grid = grid;
    ty_scene* scene = layer_scene(*state, &layer, 50, 0.4);
    ty_flux* flux = flux_of(scene, levels, 2, 4, 4 * SPP);
    const number up = mean_of(flux, TY_FLUX_UP, 1), absorbed = mean_of(flux, TY_FLUX_ABSORBED, 0);
    const number diffuse = mean_of(flux, TY_FLUX_DOWN_DIFFUSE, 0), direct = mean_of(flux, TY_FLUX_DOWN_DIRECT, 0);
    const number reflected = mean_of(flux, TY_FLUX_UP, 0), down = mean_of(flux, TY_FLUX_DOWN_DIFFUSE, 1);
    const double noise = sqrt(up.error * up.error + absorbed.error * absorbed.error +
                              0.36 * (diffuse.error * diffuse.error + direct.error * direct.error));
    assert_is("what leaves", (number){up.mean + 0.6 * (diffuse.mean + direct.mean) + absorbed.mean, noise}, 1, 0.013);
    assert_is(
        "reflected by the ground",
        (number){reflected.mean - 0.4 * (diffuse.mean + direct.mean), hypot(reflected.error, 0.4 * diffuse.error)}, 0,
        0.01);
    assert_is("light from above", mean_of(flux, TY_FLUX_DOWN_DIRECT, 1), 1, 1e-6);
    assert_is("diffuse light from above", down, 0, 0);
    printf("absorbed %.3f, up %.3f, diffuse %.3f, direct %.3f\n", absorbed.mean, up.mean, diffuse.mean, direct.mean);
    assert_true(absorbed.mean > 0.1 && up.mean > 0.2 && diffuse.mean > 0.2 && direct.mean > 0.01);
    ty_flux_destroy(flux);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

/* Radiance of a ground without a layer is that of a Lambertian surface; a sky has direct light alone. */
static void views_see_the_ground(void** state) {
    static const double levels[2] = {-0.5, 1};
    static const ty_flux_view views[2] = {{30, 120}, {150, 10}};
    const ty_medium_def layer = layer_of(0, 0, 0);
    ty_scene* scene = layer_scene(*state, &layer, 40, 0.5);
    ty_path_def path = small_def(64);
    ty_flux_def def = ty_default_flux_def();
    ty_flux* flux = NULL;
    def.levels = levels;
    def.level_count = 2;
    def.views = views;
    def.view_count = 2;
    assert_int_equal(ty_path_flux(scene, &path, &def, &flux, NULL), TY_OK);
    assert_is("radiance from below", mean_of(flux, TY_FLUX_RADIANCE, 0), 0.5 / 3.14159265358979, 1e-6);
    assert_is("radiance from above", mean_of(flux, TY_FLUX_RADIANCE, 1), 0, 1e-6);
    assert_is("flux of the ground", mean_of(flux, TY_FLUX_UP, 1), 0.5, 1e-6);
    const ty_flux_def places = ty_flux_places(flux);
    assert_close(places.upper[0], 0.7, 1e-6);
    assert_close(places.upper[1], 0.4, 1e-6);
    assert_close(places.views[1].zenith, 150, 0);
    ty_flux_destroy(flux);
    ty_scene_destroy(scene);
}

/* Scenes that do not repeat have fluxes, too, with lamps: the irradiance below a point light. */
static void open_scenes_have_fluxes(void** state) {
    static const double levels[1] = {0};
    ty_scene* scene = make_scene(*state);
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 0, 2, 0);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_path_def path = small_def(256);
    ty_flux_def def = ty_default_flux_def();
    ty_flux* flux = NULL;
    def.levels = levels;
    def.level_count = 1;
    assert_int_equal(ty_path_flux(scene, &path, &def, &flux, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "columns' corners must be given");
    for (int i = 0; i < 2; ++i) {
        def.lower[i] = -0.01;
        def.upper[i] = 0.01;
    }
    assert_int_equal(ty_path_flux(scene, &path, &def, &flux, NULL), TY_OK);
    assert_is("below a lamp", mean_of(flux, TY_FLUX_DOWN_DIRECT, 0), 0.25, 1e-4);
    ty_flux_destroy(flux);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_places_are_refused),     cmocka_unit_test(an_absorbing_layer_follows_beers_law),
        cmocka_unit_test(light_of_the_sky_is_direct),   cmocka_unit_test(emission_of_media_is_diffuse),
        cmocka_unit_test(a_layer_has_published_fluxes), cmocka_unit_test(dom_solves_the_layer),
        cmocka_unit_test(dom_solves_a_cloud),           cmocka_unit_test(dom_refuses_what_it_leaves_out),
        cmocka_unit_test(energy_is_in_balance),         cmocka_unit_test(views_see_the_ground),
        cmocka_unit_test(open_scenes_have_fluxes),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
