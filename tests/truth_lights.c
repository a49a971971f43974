/* Every kind of light on a Lambertian board against its closed form, with nothing in between and through fog. */
#include "truth.h"

static const double albedo = 0.7;

/* A board in the plane y = 0, seen from above; lights are the test's. */
static ty_scene* board_scene(ty_context* context) {
    static const double center[3] = {0, 0, 0}, u[3] = {0, 0, 1}, v[3] = {1, 0, 0};
    ty_scene* scene = new_scene(context);
    const ty_shape_def board = square_shape(center, u, v, 3, albedo);
    add_shape(scene, &board);
    return scene;
}

/* Radiance of the board at (x, 0, z), as irradiance. */
static estimate irradiance_at(ty_scene* scene, double x, double z) {
    enum { ITEMS = 64 };
    double rays[6 * ITEMS], radiance[3 * ITEMS];
    for (int i = 0; i < ITEMS; ++i) {
        set3(rays + 6 * i, x - 0.2, 0.5, z + 0.1);
        set3(rays + 6 * i + 3, 0.2, -0.5, -0.1);
    }
    radiance_along(scene, ITEMS, rays, 1 << 14, 0, radiance, NULL);
    const estimate result = estimate_of(radiance, ITEMS, 3);
    return (estimate){result.mean * pi / albedo, result.error * pi / albedo};
}

static void check(const char* name, ty_scene* scene, double x, double z, double expected) {
    assert_close(name, irradiance_at(scene, x, z), expected, 0.003);
}

static void test_directional(void** state) {
    ty_scene* scene = board_scene(*state);
    ty_light_def light = light_of(TY_LIGHT_DIRECTIONAL, 5);
    set3(light.direction, 2, -3, 6);
    add_light(scene, &light);
    commit(scene);
    check("directional", scene, 0.3, 0.4, 5 * 3.0 / 7);
    ty_scene_destroy(scene);
}

/* Two at once, so that choosing between lights is part of it. */
static void test_points(void** state) {
    ty_scene* scene = board_scene(*state);
    ty_light_def light = light_of(TY_LIGHT_POINT, 5);
    set3(light.position, 1, 2, 0);
    add_light(scene, &light);
    gray(light.color, 40);
    set3(light.position, -4, 3, 1);
    add_light(scene, &light);
    commit(scene);
    check("two points", scene, 0.3, 0.4, 5 * 2 / pow(0.49 + 4 + 0.16, 1.5) + 40 * 3 / pow(4.3 * 4.3 + 9 + 0.36, 1.5));
    ty_scene_destroy(scene);
}

static void test_spot(void** state) {
    ty_scene* scene = board_scene(*state);
    ty_light_def light = light_of(TY_LIGHT_SPOT, 5);
    set3(light.position, 0.3, 2, 0.4);
    light.cone = 40;
    light.penumbra = 0.5;
    add_light(scene, &light);
    commit(scene);
    check("spot, on its axis", scene, 0.3, 0.4, 5.0 / 4);
    /* Half way in cosine between 10 and 20 degrees the light has fallen to half. */
    const double mu = (cos(pi / 18) + cos(pi / 9)) / 2, side = 2 * sqrt(1 / (mu * mu) - 1);
    check("spot, in its penumbra", scene, 0.3, 0.4 + side, 0.5 * 5.0 / 4 * pow(mu, 3));
    check("spot, inside", scene, 0.3 + 2 * tan(pi / 18.5), 0.4, 5.0 / 4 * pow(cos(pi / 18.5), 3));
    const estimate outside = irradiance_at(scene, 0.3, 0.4 - 2 * tan(pi / 8.9));
    assert_true(outside.mean == 0);
    ty_scene_destroy(scene);
}

/* A parallelogram's light from below its edge, by the rule of Gauss in both directions. */
typedef struct area_light {
    double to[3], u[3], v[3], normal[3], x;
} area_light;

static double area_at(const void* user, double y) {
    const area_light* a = user;
    double to[3];
    for (int i = 0; i < 3; ++i) to[i] = a->to[i] + a->x * a->u[i] + y * a->v[i];
    const double d2 = dot3(to, to), facing = -dot3(to, a->normal);
    return facing > 0 && to[1] > 0 ? to[1] * facing / (d2 * d2) : 0;
}

static double area_line(const void* user, double x) {
    area_light a = *(const area_light*)user;
    a.x = x;
    return integrate(area_at, &a, 0, 1, 8);
}

static double area_irradiance(const double corner[3], const double u[3], const double v[3], double x, double z) {
    area_light a = {.to = {corner[0] - x, corner[1], corner[2] - z}};
    memcpy(a.u, u, sizeof a.u);
    memcpy(a.v, v, sizeof a.v);
    cross3(u, v, a.normal); /* as long as the area: no other factor */
    return integrate(area_line, &a, 0, 1, 8);
}

/* An area light, or a quad that glows: u x v points down to the board; the other way round it must stay dark. */
static ty_scene* area_scene(ty_context* context, bool light, const double corner[3], const double u[3],
                            const double v[3]) {
    ty_scene* scene = board_scene(context);
    ty_light_def area = light_of(TY_LIGHT_AREA, 4);
    ty_shape_def quad = ty_default_shape_def();
    memcpy(area.position, corner, sizeof area.position);
    memcpy(area.u, u, sizeof area.u);
    memcpy(area.v, v, sizeof area.v);
    memcpy(quad.origin, corner, sizeof quad.origin);
    memcpy(quad.u, u, sizeof quad.u);
    memcpy(quad.v, v, sizeof quad.v);
    gray(quad.albedo, 0);
    gray(quad.emission, 4);
    if (light)
        add_light(scene, &area);
    else
        add_shape(scene, &quad);
    commit(scene);
    return scene;
}

static void test_area(void** state) {
    static const double corner[3] = {-0.5, 0.8, -0.3}, u[3] = {1, 0.2, 0.1}, v[3] = {0.2, 0.1, 1.5};
    for (int light = 0; light < 2; ++light) {
        ty_scene *scene = area_scene(*state, light, corner, u, v), *turned = area_scene(*state, light, corner, v, u);
        check(light ? "area light" : "emissive quad", scene, -1.5, -1.2, 4 * area_irradiance(corner, u, v, -1.5, -1.2));
        assert_true(irradiance_at(turned, -1.5, -1.2).mean == 0);
        ty_scene_destroy(scene);
        ty_scene_destroy(turned);
    }
}

/* E = pi L (r / d)^2 cos, as long as all of the ball is above the board. */
static void test_ball(void** state) {
    ty_scene* scene = board_scene(*state);
    const ty_shape_def ball = sphere_shape(0.5, 1.5, -0.5, 0.7, 0, 3);
    add_shape(scene, &ball);
    commit(scene);
    const double d2 = 1.3 * 1.3 + 2.25 + 0.9 * 0.9;
    check("emissive ball", scene, -0.8, 0.4, pi * 3 * 0.49 / d2 * 1.5 / sqrt(d2));
    ty_scene_destroy(scene);
}

/* The six faces of a glowing box, of which the board sees five at most. */
static void test_box(void** state) {
    ty_scene* scene = board_scene(*state);
    ty_shape_def box = ty_default_shape_def();
    box.kind = TY_SHAPE_BOX;
    set3(box.origin, 0, 0.5, 0);
    set3(box.u, 1, 1.2, 0.6);
    gray(box.albedo, 0);
    gray(box.emission, 2);
    add_shape(scene, &box);
    commit(scene);
    static const double low[3] = {0, 0.5, 0}, x[3] = {1, 0, 0}, y[3] = {0, 0.7, 0}, z[3] = {0, 0, 0.6};
    const double expected = area_irradiance(low, x, z, -0.6, -0.5) + area_irradiance(low, z, y, -0.6, -0.5) +
                            area_irradiance(low, y, x, -0.6, -0.5);
    check("emissive box", scene, -0.6, -0.5, 2 * expected);
    ty_scene_destroy(scene);
}

/* Lights of every kind together, all in fog, reach the board as exp(-depth) where they are points and beams. */
static void test_through_fog(void** state) {
    ty_scene* scene = board_scene(*state);
    ty_medium_def fog = medium_cube(4, 0, 0.3, 0);
    rgb(fog.sigma_a, 0.3, 0.6, 0.9);
    add_medium(scene, &fog);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 5), lamp = light_of(TY_LIGHT_POINT, 5);
    set3(sun.direction, 0, -1, 0);
    set3(lamp.position, 0.3, 1, 0.4);
    add_light(scene, &sun);
    add_light(scene, &lamp);
    commit(scene);
    double ray[6] = {0.3, 2, 0.4, 0, -1, 0}, radiance[3];
    radiance_along(scene, 1, ray, 1 << 16, 0, radiance, NULL);
    for (int c = 0; c < 3; ++c) {
        const double sigma = 0.3 * (c + 1);
        const estimate found = {radiance[c] * pi / albedo, 0};
        assert_close("sun and lamp through fog", found, exp(-2 * sigma) * (5 * exp(-4 * sigma) + 5 * exp(-sigma)),
                     0.005);
    }
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_directional), cmocka_unit_test(test_points), cmocka_unit_test(test_spot),
        cmocka_unit_test(test_area),        cmocka_unit_test(test_ball),   cmocka_unit_test(test_box),
        cmocka_unit_test(test_through_fog),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
