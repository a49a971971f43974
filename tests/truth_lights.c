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

static void directional_light_is_right(void** state) {
    ty_scene* scene = board_scene(*state);
    ty_light_def light = light_of(TY_LIGHT_DIRECTIONAL, 5);
    set3(light.direction, 2, -3, 6);
    add_light(scene, &light);
    commit(scene);
    check("directional", scene, 0.3, 0.4, 5 * 3.0 / 7);
    ty_scene_destroy(scene);
}

/* Two at once, so that choosing between lights is part of it. */
static void point_lights_are_right(void** state) {
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

static void spot_lights_are_right(void** state) {
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
    const double dim = 0.25 * cos(pi / 18) + 0.75 * cos(pi / 9); /* x^2 (3 - 2 x) of 1/4 */
    check("spot, inside", scene, 0.3 + 2 * tan(pi / 18.5), 0.4, 5.0 / 4 * pow(cos(pi / 18.5), 3));
    check("spot, far out in its penumbra", scene, 0.3 + 2 * sqrt(1 / (dim * dim) - 1), 0.4,
          0.15625 * 5.0 / 4 * pow(dim, 3));
    const estimate outside = irradiance_at(scene, 0.3, 0.4 - 2 * tan(pi / 8.9));
    assert_true(outside.mean == 0);
    ty_scene_destroy(scene);
}

/* Irradiance of the board at (x, 0, z) from a sphere of unit radiance that shines in the cone of a spot, by quadrature
 * over the directions to it. */
static double sphere_irradiance(const ty_light_def* light, double x, double z) {
    enum { RINGS = 200, SECTORS = 200 };
    double to[3] = {light->position[0] - x, light->position[1], light->position[2] - z}, sum = 0;
    const double distance = sqrt(dot3(to, to)), cap = 1 - sqrt(1 - pow(light->radius / distance, 2));
    const double half = light->cone * pi / 360, outer = cos(half), inner = cos(half * (1 - light->penumbra));
    double beside[3], other[3];
    normalize3(to);
    cross3(to, fabs(to[0]) < 0.5 ? (double[]){1, 0, 0} : (double[]){0, 0, 1}, beside);
    normalize3(beside);
    cross3(to, beside, other);
    for (int i = 0; i < RINGS; ++i)
        for (int j = 0; j < SECTORS; ++j) {
            const double mu = 1 - cap * (i + 0.5) / RINGS, side = sqrt(1 - mu * mu), turn = 2 * pi * j / SECTORS;
            double wi[3];
            for (int a = 0; a < 3; ++a) wi[a] = mu * to[a] + side * (cos(turn) * beside[a] + sin(turn) * other[a]);
            const double s = fmin(fmax((-dot3(wi, light->direction) - outer) / (inner - outer), 0), 1);
            sum += s * s * (3 - 2 * s) * wi[1];
        }
    return 2 * pi * cap * sum / (RINGS * SECTORS);
}

/* A sphere that is wholly above the board lights it as a point in its middle would; that of a spot has its cone. */
static void lamps_with_a_radius_are_right(void** state) {
    ty_scene* scene = board_scene(*state);
    ty_light_def light = light_of(TY_LIGHT_POINT, 5);
    set3(light.position, 1, 2, 0);
    light.radius = 0.6;
    add_light(scene, &light);
    commit(scene);
    assert_int_equal(ty_scene_get_info(scene).lights, 1);
    check("ball", scene, 0.3, 0.4, 5 * 2 / pow(0.49 + 4 + 0.16, 1.5));
    ty_scene_destroy(scene);
    scene = board_scene(*state);
    light = light_of(TY_LIGHT_SPOT, 5);
    set3(light.position, 0.3, 2, 0.4);
    set3(light.direction, 0, -1, 0);
    light.radius = 0.25;
    light.cone = 40;
    light.penumbra = 0.5;
    add_light(scene, &light);
    commit(scene);
    const double per_radiance = 5 / (pi * 0.25 * 0.25);
    for (int i = 0; i < (in_full() ? 4 : 3); ++i) /* the last one lies in the penumbra, and takes more samples */
        check("ball of a spot", scene, 0.3 + 0.3 * i, 0.4,
              per_radiance * sphere_irradiance(&light, 0.3 + 0.3 * i, 0.4));
    const estimate outside = irradiance_at(scene, 0.3, 0.4 - 2 * tan(pi / 5));
    assert_true(outside.mean == 0);
    ty_scene_destroy(scene);
}

/* Lambert's rule for the irradiance from a polygon of unit radiance: half the sum over its edges of the angle an edge
 * is seen under times the cosine between the board's normal and that of the plane through the edge and (x, 0, z). */
static double polygon_irradiance(const double corner[3], const double u[3], const double v[3], double x, double z) {
    double to[4][3], sum = 0;
    for (int i = 0; i < 4; ++i) {
        for (int a = 0; a < 3; ++a)
            to[i][a] = corner[a] + (i == 1 || i == 2 ? u[a] : 0) + (i >= 2 ? v[a] : 0) - (double[]){x, 0, z}[a];
        normalize3(to[i]);
    }
    for (int i = 0; i < 4; ++i) {
        double across[3];
        cross3(to[i], to[(i + 1) % 4], across);
        sum += 0.5 * acos(dot3(to[i], to[(i + 1) % 4])) * across[1] / sqrt(dot3(across, across));
    }
    return fabs(sum);
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

static void area_lights_are_right(void** state) {
    static const double corner[3] = {-0.5, 0.8, -0.3}, u[3] = {1, 0.2, 0.1}, v[3] = {0.2, 0.1, 1.5};
    for (int light = 0; light < 2; ++light) {
        ty_scene *scene = area_scene(*state, light, corner, u, v), *turned = area_scene(*state, light, corner, v, u);
        check(light ? "area light" : "emissive quad", scene, -1.5, -1.2,
              4 * polygon_irradiance(corner, u, v, -1.5, -1.2));
        assert_true(irradiance_at(turned, -1.5, -1.2).mean == 0);
        ty_scene_destroy(scene);
        ty_scene_destroy(turned);
    }
}

static void emissive_panels_are_right(void** state) {
    static const double corner[3] = {-0.5, 0.6, -0.4}, u[3] = {1.2, 0, 0.1}, v[3] = {-0.2, 0, 0.9};
    static const double at[3][2] = {{0, 0}, {-0.5, -0.4}, {1.4, -0.6}};
    for (int light = 0; light < 2; ++light) {
        ty_scene* scene = area_scene(*state, light, corner, u, v);
        for (int i = 0; i < 3; ++i) {
            const double x = at[i][0], z = at[i][1];
            check(light ? "parallel area light" : "parallel emissive quad", scene, x, z,
                  4 * polygon_irradiance(corner, u, v, x, z));
        }
        ty_scene_destroy(scene);
    }
}

/* E = pi L (r / d)^2 cos, as long as all of the ball is above the board. */
static void emissive_balls_are_right(void** state) {
    ty_scene* scene = board_scene(*state);
    const ty_shape_def ball = sphere_shape(0.5, 1.5, -0.5, 0.7, 0, 3);
    add_shape(scene, &ball);
    commit(scene);
    const double d2 = 1.3 * 1.3 + 2.25 + 0.9 * 0.9;
    check("emissive ball", scene, -0.8, 0.4, pi * 3 * 0.49 / d2 * 1.5 / sqrt(d2));
    ty_scene_destroy(scene);
}

/* The six faces of a glowing box, of which the board sees five at most. */
static void emissive_boxes_are_right(void** state) {
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
    const double expected = polygon_irradiance(low, x, z, -0.6, -0.5) + polygon_irradiance(low, z, y, -0.6, -0.5) +
                            polygon_irradiance(low, y, x, -0.6, -0.5);
    check("emissive box", scene, -0.6, -0.5, 2 * expected);
    ty_scene_destroy(scene);
}

/* ---- environments ---- */

static void constant_environments_are_right(void** state) {
    ty_scene* scene = board_scene(*state);
    ty_light_def light = light_of(TY_LIGHT_ENVIRONMENT, 3);
    light.scale = 0.5f;
    add_light(scene, &light);
    commit(scene);
    check("constant environment", scene, 0.3, 0.4, pi * 1.5);
    ty_scene_destroy(scene);
}

enum { MAP_WIDTH = 16, MAP_HEIGHT = 8, BRIGHT_ROW = 2 };

/* Irradiance by a bright row of a map on a board that faces up, at an angle from the vertical: radiance is linear
 * between the rows' middles. */
static double bright_row(const void* user, double angle) {
    (void)user;
    const double rows = angle / pi * MAP_HEIGHT - (BRIGHT_ROW + 0.5);
    return fmax(0, 1 - fabs(rows)) * sin(angle) * cos(angle);
}

/* A map that is dark but for one texel, which lights as much as its share of a whole bright row. */
static void a_bright_texel_is_sampled(void** state) {
    ty_image* map = NULL;
    must(*state, ty_image_create_rgb(*state, MAP_WIDTH, MAP_HEIGHT, &map));
    for (int c = 0; c < 3; ++c) ty_image_plane(map, c)[BRIGHT_ROW * MAP_WIDTH + 5] = 40;
    ty_scene* scene = board_scene(*state);
    ty_light_def light = light_of(TY_LIGHT_ENVIRONMENT, 1);
    light.image = map;
    light.rotation = 33;
    add_light(scene, &light);
    commit(scene);
    const double middle = pi * (BRIGHT_ROW + 0.5) / MAP_HEIGHT, step = pi / MAP_HEIGHT;
    const double row = ty_integrate(bright_row, NULL, middle - step, middle, 2) +
                       ty_integrate(bright_row, NULL, middle, middle + step, 2);
    check("environment with one bright texel", scene, 0.3, 0.4, 40 * 2 * pi / MAP_WIDTH * row);
    ty_scene_destroy(scene);
    ty_image_destroy(map);
}

/* ---- together ---- */

/* Forty lamps and spots under nine panels: what they bring adds up, however few of them a path looks at. */
static void many_lights_add_up(void** state) {
    static const double x = 0.3, z = -0.4, u[3] = {0.5, 0, 0}, v[3] = {0, 0, 0.5};
    ty_scene* scene = board_scene(*state);
    double expected = 0, place[4];
    for (int i = 0; i < 40; ++i) {
        ty_light_def light = light_of(i % 4 ? TY_LIGHT_POINT : TY_LIGHT_SPOT, 1 + i % 7);
        even_point(i, place);
        set3(light.position, 6 * place[0] - 3, 0.8 + 1.7 * place[1], 6 * place[2] - 3);
        light.cone = 120;
        light.penumbra = 0;
        add_light(scene, &light);
        const double to[3] = {x - light.position[0], light.position[1], z - light.position[2]};
        const double d2 = dot3(to, to), mu = to[1] / sqrt(d2);
        if (light.kind == TY_LIGHT_POINT || mu > 0.5) expected += (1 + i % 7) * mu / d2;
    }
    for (int i = 0; i < 9; ++i) {
        ty_light_def light = light_of(TY_LIGHT_AREA, 2);
        set3(light.position, i % 3 * 2 - 2, 3, i / 3 * 2 - 2);
        memcpy(light.u, u, sizeof u);
        memcpy(light.v, v, sizeof v);
        add_light(scene, &light);
        expected += 2 * polygon_irradiance(light.position, u, v, x, z);
    }
    commit(scene);
    check("forty lamps and nine panels", scene, x, z, expected);
    ty_scene_destroy(scene);
}

/* A sun and a lamp, both in fog, reach the board as exp(-depth) where they are points and beams. */
static void lights_are_right_through_fog(void** state) {
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
        cmocka_unit_test(directional_light_is_right),
        cmocka_unit_test(point_lights_are_right),
        cmocka_unit_test(spot_lights_are_right),
        cmocka_unit_test(lamps_with_a_radius_are_right),
        cmocka_unit_test(area_lights_are_right),
        cmocka_unit_test(emissive_panels_are_right),
        cmocka_unit_test(emissive_balls_are_right),
        cmocka_unit_test(emissive_boxes_are_right),
        cmocka_unit_test(constant_environments_are_right),
        cmocka_unit_test(a_bright_texel_is_sampled),
        cmocka_unit_test(many_lights_add_up),
        cmocka_unit_test(lights_are_right_through_fog),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
