/* The sky against path tracing of the planet: a ball in nested balls of air and haze under the sun. */
#include "truth.h"

enum { SHELLS = 60, WIDTH = 256, HEIGHT = WIDTH / 2, AZIMUTHS = 3, RAYS = 8 * AZIMUTHS };

/* The atmosphere of src/scene/lights/atmosphere.c, without ozone, whose layer no nested balls make. */
static const double planet = 6360e3, observer = 2, thickness = 100e3;
static const double air_scattering[3] = {5.8e-6, 13.5e-6, 33.1e-6}, air_scale = 8000;
static const double haze_scattering = 4e-6, haze_extinction = 4e-6 / 0.9, haze_scale = 1200, haze_g = 0.76;

typedef struct sky_case {
    double elevation, haze, ground;
    double tolerance; /* of each ray, beside four times its noise */
    bool quick;
} sky_case;

static double shell_height(int index) {
    return thickness * index * index / ((double)SHELLS * SHELLS);
}

/* Mean density of a constituent between two heights. */
static double mean_density(double scale, int shell) {
    if (shell >= SHELLS) return 0;
    const double low = shell_height(shell), high = shell_height(shell + 1);
    return scale * (exp(-low / scale) - exp(-high / scale)) / (high - low);
}

/* Each ball adds what its shell has more of than the shell above. */
static ty_scene* planet_scene(ty_context* context, const sky_case* c) {
    ty_scene* scene = new_scene(context);
    const double elevation = c->elevation * pi / 180;
    ty_shape_def ground = sphere_shape(0, -planet - observer, 0, planet, c->ground, 0);
    add_shape(scene, &ground);
    for (int i = 0; i < SHELLS; ++i) {
        const double air = mean_density(air_scale, i) - mean_density(air_scale, i + 1);
        const double haze = c->haze * (mean_density(haze_scale, i) - mean_density(haze_scale, i + 1));
        ty_medium_def shell =
            medium_sphere(planet + shell_height(i + 1), 0, haze * (haze_extinction - haze_scattering), 0);
        set3(shell.sphere_center, 0, -planet - observer, 0);
        shell.phase_count = 2;
        shell.phase[0] = (ty_phase_lobe){.kind = TY_PHASE_DRAINE, .alpha = 1};
        shell.phase[1] = (ty_phase_lobe){.kind = TY_PHASE_DRAINE, .g = haze_g, .alpha = 1};
        for (int k = 0; k < 3; ++k) {
            shell.phase[0].weight[k] = (float)(air * air_scattering[k]);
            shell.phase[1].weight[k] = (float)(haze * haze_scattering);
            shell.sigma_s[k] = (float)(air * air_scattering[k] + haze * haze_scattering);
        }
        add_medium(scene, &shell);
    }
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    set3(sun.direction, -cos(elevation), -sin(elevation), 0);
    add_light(scene, &sun);
    commit(scene);
    return scene;
}

static ty_image* sky_image(ty_context* context, const sky_case* c, ty_sky_scattering scattering) {
    ty_sky_def def = ty_default_sky_def();
    const double elevation = c->elevation * pi / 180;
    set3(def.sun_direction, -cos(elevation), -sin(elevation), 0);
    gray(def.solar, 1);
    gray(def.ground, c->ground);
    def.haze = c->haze;
    def.ozone = 0;
    def.width = WIDTH;
    def.scattering = scattering;
    ty_image* image = NULL;
    float sun[3];
    must(context, ty_sky_create_image(context, &def, &image, sun));
    return image;
}

/* A view along the centre of the map's pixel nearest to an elevation, degrees, and to an azimuth, as a part of half a
 * turn from the sun. */
static void view_at(double elevation, double azimuth, double view[6], int* pixel) {
    const int row = (int)((90 - elevation) / 180 * HEIGHT), column = WIDTH / 2 + (int)(azimuth * (WIDTH / 2 - 1));
    const double down = pi * (row + 0.5) / HEIGHT, turn = 2 * pi * ((column + 0.5) / WIDTH - 0.5);
    const double values[6] = {0, 0, 0, sin(down) * cos(turn), cos(down), sin(down) * sin(turn)};
    memcpy(view, values, sizeof values);
    *pixel = row * WIDTH + column;
}

static void compare(ty_context* context, const sky_case* c) {
    const int32_t spp = fewer(65536, 16);
    double views[6 * RAYS], radiance[3 * RAYS], variance[3 * RAYS], worst = 0, squares[3] = {0, 0, 0};
    static const double elevations[RAYS / AZIMUTHS] = {89.3, 60, 45, 20, 12, 5, 2.1, 0.7};
    int pixels[RAYS];
    ty_scene* scene = planet_scene(context, c);
    ty_image* images[3];
    for (int i = 0; i < 3; ++i) images[i] = sky_image(context, c, (ty_sky_scattering)i);
    for (int i = 0; i < RAYS; ++i)
        view_at(elevations[i / AZIMUTHS], (double)(i % AZIMUTHS) / (AZIMUTHS - 1), &views[6 * i], &pixels[i]);
    radiance_along(scene, RAYS, views, spp, 0, radiance, variance);
    printf("sun at %g degrees, haze %g, ground %g: sky / path - 1, %%\n", c->elevation, c->haze, c->ground);
    for (int i = 0; i < 3 * RAYS; ++i) {
        double off[3];
        const double noise = sqrt(variance[i]) / radiance[i];
        for (int j = 0; j < 3; ++j)
            off[j] = (double)ty_image_plane_const(images[j], i % 3)[pixels[i / 3]] / radiance[i] - 1;
        printf("  up %5.1f, azimuth %5.1f, channel %d: %9.3g, orders %+6.1f, isotropic %+6.1f, single %+6.1f +- %.1f\n",
               asin(views[6 * (i / 3) + 4]) * 180 / pi,
               atan2(views[6 * (i / 3) + 5], views[6 * (i / 3) + 3]) * 180 / pi, i % 3, radiance[i], 100 * off[0],
               100 * off[1], 100 * off[2], 100 * noise);
        worst = fmax(worst, fabs(off[0]) - 4 * noise - c->tolerance);
        for (int j = 0; j < 3; ++j) squares[j] += off[j] * off[j] / (3 * RAYS);
    }
    printf("RMS: orders %.2f %%, isotropic %.2f %%, single %.2f %%\n", 100 * sqrt(squares[0]), 100 * sqrt(squares[1]),
           100 * sqrt(squares[2]));
    for (int i = 0; i < 3; ++i) ty_image_destroy(images[i]);
    ty_scene_destroy(scene);
    if (worst > 0) fail_msg("off by %g more than its bound", worst);
}

static void skies_are_as_bright_as_the_planets(void** state) {
    static const sky_case cases[] = {{60, 1, 0.2, 0.015, false}, {20, 1, 0.2, 0.015, true}, {5, 1, 0.2, 0.015, false},
                                     {0, 1, 0.2, 0.02, false},   {-4, 1, 0.2, 0.05, false}, {20, 0, 0.8, 0.02, false},
                                     {60, 0, 1, 0.025, false},   {20, 10, 0.2, 0.05, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        if (in_full() || cases[i].quick) compare(*state, &cases[i]);
}

/* A box with the ground under it holds the lowest air; the sky above is seen through it as it is from the ground. */
static void air_adds_nothing_to_the_sky(void** state) {
    enum { VIEWS = 9 };
    static const double elevations[3] = {80, 40, 15}, low[3] = {-60e3, 0, -60e3}, high[3] = {60e3, 4000, 60e3};
    static const double center[3] = {0, 0, 0}, x[3] = {1, 0, 0}, back[3] = {0, 0, -1};
    static const double tolerance = 0.01; /* measured: .5 % +- .5 %, 1.3 +- .4 at the horizon */
    ty_context* context = *state;
    ty_scene* scene = new_scene(context);
    ty_sky_def def = ty_default_sky_def();
    const double sun_elevation = 30 * pi / 180;
    set3(def.sun_direction, -cos(sun_elevation), -sin(sun_elevation), 0);
    def.haze = 3;
    def.width = WIDTH;
    ty_image* whole = NULL;
    ty_image* above = NULL;
    float irradiance[3];
    must(context, ty_sky_create_image(context, &def, &whole, irradiance));
    def.height = high[1] - low[1];
    must(context, ty_sky_create_image(context, &def, &above, irradiance));
    must(context, ty_scene_add_sky_air(scene, &def, low, high));
    const ty_shape_def ground = square_shape(center, x, back, 60e3, 0.2);
    ty_light_def sky = light_of(TY_LIGHT_ENVIRONMENT, 1), sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    sky.image = above;
    memcpy(sun.direction, def.sun_direction, sizeof sun.direction);
    memcpy(sun.color, irradiance, sizeof sun.color);
    add_shape(scene, &ground);
    add_light(scene, &sky);
    add_light(scene, &sun);
    commit(scene);
    double views[6 * VIEWS], radiance[3 * VIEWS], variance[3 * VIEWS], worst = 0;
    int pixels[VIEWS];
    for (int i = 0; i < VIEWS; ++i) {
        view_at(elevations[i / 3], 0.1 + 0.4 * (i % 3), &views[6 * i], &pixels[i]);
        views[6 * i + 1] = 2;
    }
    radiance_along(scene, VIEWS, views, fewer(65536, 8), 0, radiance, variance);
    for (int i = 0; i < 3 * VIEWS; ++i) {
        const double expected = (double)ty_image_plane_const(whole, i % 3)[pixels[i / 3]];
        const double off = radiance[i] / expected - 1, noise = sqrt(variance[i]) / expected;
        printf("  view %d, channel %d: %9.3g, through air %+5.1f %% +- %.1f\n", i / 3, i % 3, expected, 100 * off,
               100 * noise);
        worst = fmax(worst, fabs(off) - 4 * noise - tolerance);
    }
    ty_image_destroy(whole);
    ty_image_destroy(above);
    ty_scene_destroy(scene);
    if (worst > 0) fail_msg("off by %g more than its bound", worst);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(skies_are_as_bright_as_the_planets),
                                       cmocka_unit_test(air_adds_nothing_to_the_sky)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
