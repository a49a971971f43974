/* Light through smooth interfaces, as next-event estimation finds it, against sampled directions alone: a ball of
 * glowing gas, which only those meet, looks like a lamp. Window panes; fog around glass. */
#include "truth.h"

static void make_glass(ty_shape_def* shape, double ior) {
    gray(shape->albedo, 1);
    shape->gloss.specular = 1;
    shape->gloss.transmission = 1;
    shape->gloss.roughness = 0;
    shape->gloss.ior = (float)ior;
    shape->gloss.solid = true;
}

static void add_glass_ball(ty_scene* scene, double y, double radius, double ior) {
    ty_shape_def ball = sphere_shape(0, y, 0, radius, 1, 0);
    make_glass(&ball, ior);
    add_shape(scene, &ball);
}

static void add_floor(ty_scene* scene, double height, double half, double albedo) {
    const double center[3] = {0, height, 0}, x[3] = {1, 0, 0}, z[3] = {0, 0, -1};
    const ty_shape_def shape = square_shape(center, x, z, half, albedo);
    add_shape(scene, &shape);
}

/* ---- emitters with a size ---- */

static const double lamp_at[3] = {1.2, 3, 0.5};

/* A lamp of radiance 1: a sphere that next-event estimation samples, or as much of an opaque glowing gas. */
static void add_lamp(ty_scene* scene, double radius, bool sampled) {
    if (sampled) {
        const ty_shape_def lamp = sphere_shape(lamp_at[0], lamp_at[1], lamp_at[2], radius, 0, 1);
        add_shape(scene, &lamp);
        return;
    }
    ty_medium_def gas = medium_sphere(radius, 0, 1e4, 0);
    for (int a = 0; a < 3; ++a) gas.sphere_center[a] = lamp_at[a];
    gray(gas.emission, 1);
    add_medium(scene, &gas);
}

static ty_scene* glass_on_a_floor(ty_context* context, double radius, bool sampled) {
    ty_scene* scene = new_scene(context);
    add_glass_ball(scene, 0.6, 0.6, 1.5);
    add_floor(scene, 0, 2, 0.7);
    add_lamp(scene, radius, sampled);
    set_camera(scene, 0, 1.2, 4, 35);
    commit(scene);
    return scene;
}

static ty_scene* milk_in_a_ball(ty_context* context, double radius, bool sampled) {
    ty_scene* scene = new_scene(context);
    const ty_medium_def milk = medium_sphere(0.8, 6, 0, 0);
    add_glass_ball(scene, 0, 0.8, 1.33);
    add_medium(scene, &milk);
    add_lamp(scene, radius, sampled);
    set_camera(scene, 0, 0, 4, 26);
    commit(scene);
    return scene;
}

static void compare(ty_context* context, const char* name, ty_scene* (*make)(ty_context*, double, bool), double radius,
                    int32_t spp, double tolerance) {
    ty_scene *sampled = make(context, radius, true), *met = make(context, radius, false);
    ty_image *a = render(sampled, 32, spp, 1), *b = render(met, 32, 4 * spp, 2);
    assert_same_channel(name, a, 1, b, 1, tolerance);
    ty_image_destroy(a);
    ty_image_destroy(b);
    ty_scene_destroy(sampled);
    ty_scene_destroy(met);
}

static void lamps_light_a_floor_through_glass(void** state) {
    compare(*state, "glass ball on a floor, lamp", glass_on_a_floor, 0.55, in_full() ? 4096 : 128,
            in_full() ? 0.01 : 0.05);
}

static void lamps_light_milk_in_a_ball(void** state) {
    compare(*state, "milk in a ball, lamp", milk_in_a_ball, 0.6, in_full() ? 1024 : 96, in_full() ? 0.02 : 0.06);
}

/* ---- the sun ---- */

static const double to_sun[3] = {0.36, 0.8, 0.48};

/* The sun of irradiance 1, or an emitter of that, `degrees` wide. */
static void add_sun(ty_scene* scene, double degrees) {
    const double distance = 200, radius = distance * sin(degrees * pi / 360);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    set3(sun.direction, -to_sun[0], -to_sun[1], -to_sun[2]);
    const ty_shape_def disc = sphere_shape(distance * to_sun[0], distance * to_sun[1], distance * to_sun[2], radius, 0,
                                           1 / (pi * pow(sin(degrees * pi / 360), 2)));
    if (degrees > 0)
        add_shape(scene, &disc);
    else
        add_light(scene, &sun);
}

/* Light that milk scatters; the emitter's mirror image in the ball is not seen of the sun. */
static estimate milk_in_the_sun(ty_context* context, double degrees, int32_t spp) {
    ty_scene* scene = new_scene(context);
    const ty_medium_def milk = medium_sphere(0.8, 6, 0, 0);
    add_glass_ball(scene, 0, 0.8, 1.33);
    add_medium(scene, &milk);
    add_sun(scene, degrees);
    set_camera(scene, 0, 0, 4, 26);
    commit(scene);
    ty_path_def def = ty_default_path_def();
    double values[64];
    for (int i = 0; i < 64; ++i) {
        ty_image* image = NULL;
        def.spp = spp;
        def.seed = (uint64_t)i;
        def.width = def.height = 8;
        def.aovs = TY_AOV_MULTIPLE;
        must(context, ty_path_render(scene, &def, &image, NULL));
        const float* green = ty_image_plane_const(image, ty_image_find_channel(image, "multiple.G"));
        values[i] = 0;
        for (int k = 0; k < 64; ++k) values[i] += (double)green[k] / 64;
        ty_image_destroy(image);
    }
    ty_scene_destroy(scene);
    return estimate_of(values, 64, 1);
}

static void milk_is_as_bright_in_the_sun(void** state) {
    const estimate wide = milk_in_the_sun(*state, 11, in_full() ? 256 : 16);
    assert_close("milk in the sun and under an emitter", milk_in_the_sun(*state, 0, in_full() ? 128 : 8), wide.mean,
                 in_full() ? 0.015 : 0.04);
}

/* The fluence of a refracted beam that its medium absorbs. */
static void fluence_under_water_has_the_sun(void** state) {
    ty_scene* scene = new_scene(*state);
    ty_shape_def water = ty_default_shape_def();
    water.kind = TY_SHAPE_BOX;
    set3(water.origin, -500, -100, -500);
    set3(water.u, 500, 0, 500);
    make_glass(&water, 1.33);
    gray(water.gloss.attenuation_color, 0.5);
    water.gloss.attenuation_distance = 1;
    add_shape(scene, &water);
    add_sun(scene, 0);
    commit(scene);
    ty_path_def def = ty_default_path_def();
    def.spp = 16;
    const double point[3] = {0, -0.9, 0}, cosine = 0.8, inner = sqrt(1 - 0.36 / (1.33 * 1.33));
    const double p = (1.33 * cosine - inner) / (1.33 * cosine + inner),
                 s = (cosine - 1.33 * inner) / (cosine + 1.33 * inner);
    const int32_t size[3] = {1, 1, 1};
    double fluence[3], variance[3];
    must(*state, ty_path_fluence(scene, &def, point, point, size, fluence, NULL, variance));
    assert_close("fluence under water in the sun", (estimate){fluence[0], sqrt(variance[0])},
                 cosine / inner * (1 - (p * p + s * s) / 2) * pow(0.5, 0.9 / inner), 1e-3);
    ty_scene_destroy(scene);
}

/* ---- panes ---- */

static void add_pane(ty_scene* scene, double height, double specular) {
    const double center[3] = {0, height, 0}, x[3] = {1, 0, 0}, z[3] = {0, 0, 1};
    ty_shape_def pane = square_shape(center, x, z, 3, 1);
    rgb(pane.albedo, 0.9, 0.6, 1);
    pane.gloss.transmission = 1;
    pane.gloss.roughness = 0;
    pane.gloss.specular = (float)specular;
    add_shape(scene, &pane);
}

/* Radiance seen along one ray; its error by its own variance. */
static estimate see(const ty_scene* scene, const double view[6], int32_t spp, int32_t max_depth, int channel) {
    double radiance[3], variance[3];
    radiance_along(scene, 1, view, spp, max_depth, radiance, variance);
    return (estimate){radiance[channel], sqrt(variance[channel])};
}

/* A lamp and the sun on a floor below a pane: each loses Schlick's reflectance, and takes the colour. */
static void lamps_and_the_sun_shine_through_a_pane(void** state) {
    for (int sun = 0; sun < 2; ++sun) {
        ty_scene* scene = new_scene(*state);
        ty_light_def light = light_of(sun ? TY_LIGHT_DIRECTIONAL : TY_LIGHT_POINT, 3);
        set3(light.position, 0.8, 2, 0);
        set3(light.direction, -0.4 / sqrt(1.16), -1 / sqrt(1.16), 0);
        add_light(scene, &light);
        add_floor(scene, 0, 10, 0.5);
        add_pane(scene, 1, 1);
        commit(scene);
        const double view[6] = {0, 0.5, 0, 0, -1, 0}, cosine = 1 / sqrt(1.16);
        const double passed = 1 - (0.04 + 0.96 * pow(1 - cosine, 5));
        const double irradiance = 3 * cosine / (sun ? 1 : 4.64);
        for (int c = 0; c < 2; ++c)
            assert_close(sun ? "sun through a pane" : "lamp through a pane", see(scene, view, 16, 1, c),
                         0.5 / pi * irradiance * passed * (c == 0 ? 0.9 : 0.6), 1e-3);
        ty_scene_destroy(scene);
    }
}

/* The light that a pane reflects and the light that it lets pass add up. */
static void panes_before_a_white_sky(void** state) {
    ty_scene* scene = new_scene(*state);
    const ty_light_def sky = light_of(TY_LIGHT_ENVIRONMENT, 1);
    add_light(scene, &sky);
    add_pane(scene, 0, 1);
    commit(scene);
    static const double cosines[] = {1, 0.5, 0.1};
    for (int i = 0; i < 3; ++i) {
        const double sine = sqrt(1 - cosines[i] * cosines[i]);
        const double view[6] = {-sine, cosines[i], 0, sine, -cosines[i], 0};
        assert_close("white pane before a white sky", see(scene, view, 4096, 0, 2), 1, 4e-3);
    }
    ty_scene_destroy(scene);
}

/* A lamp above a pane in a foggy room. */
static ty_scene* pane_in_fog(ty_context* context, double radius, bool sampled) {
    ty_scene* scene = new_scene(context);
    const ty_medium_def fog = medium_cube(2, 0.3, 0, 0.5);
    add_medium(scene, &fog);
    add_floor(scene, -1, 2, 0.6);
    add_pane(scene, 1, 1);
    add_lamp(scene, radius, sampled);
    set_camera(scene, 0, 0, 5, 35);
    commit(scene);
    return scene;
}

static void lamps_shine_through_a_pane_in_fog(void** state) {
    compare(*state, "pane in fog, lamp", pane_in_fog, 0.4, in_full() ? 4096 : 192, in_full() ? 0.01 : 0.04);
}

/* ---- fog around solids ---- */

/* An emitter behind a ball of ior 1 in fog: fog is around the ball alone, and a medium in it, which fills no boundary,
 * is there. */
static void fog_stays_out_of_glass(void** state) {
    for (int filled = 0; filled < 2; ++filled) {
        ty_scene* scene = new_scene(*state);
        const double behind[3] = {0, 0, -3}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
        ty_shape_def emitter = square_shape(behind, x, y, 1, 0);
        gray(emitter.emission, 1);
        const ty_medium_def fog = medium_cube(2, 0, 0.5, 0), smoke = medium_cube(0.25, 0, 2, 0);
        add_medium(scene, &fog);
        if (filled) add_medium(scene, &smoke);
        add_glass_ball(scene, 0, 0.8, 1);
        add_shape(scene, &emitter);
        commit(scene);
        const double view[6] = {0, 0, 3, 0, 0, -1};
        assert_close(filled ? "fog around a ball with smoke" : "fog around a ball", see(scene, view, 16, 0, 0),
                     exp(-0.5 * 2.4 - (filled ? 1 : 0)), 1e-3);
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_light_a_floor_through_glass),      cmocka_unit_test(lamps_light_milk_in_a_ball),
        cmocka_unit_test(milk_is_as_bright_in_the_sun),           cmocka_unit_test(fluence_under_water_has_the_sun),
        cmocka_unit_test(lamps_and_the_sun_shine_through_a_pane), cmocka_unit_test(panes_before_a_white_sky),
        cmocka_unit_test(lamps_shine_through_a_pane_in_fog),      cmocka_unit_test(fog_stays_out_of_glass),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
