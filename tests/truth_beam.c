/* Single scattering along a ray in closed form: of sunlight in a ball, of a spot's cone, of a point source (airlight).
 */
#include "truth.h"

enum { RAYS = 64 };

static const double anisotropies[] = {0, 0.7, -0.3};

/* Radiance that a ray collects: light that reaches a point of it, scattered towards the eye, and attenuated on both
 * ways. */
typedef struct airlight {
    double origin[3], way[3]; /* of the ray */
    double sigma_s, sigma_t, g;
    double radius; /* of the medium, a ball about the origin */
    ty_light_def light;
} airlight;

/* The distance from a point in the ball to its surface. */
static double to_surface(const airlight* a, const double point[3], const double way[3]) {
    const double along = dot3(point, way);
    return sqrt(along * along + a->radius * a->radius - dot3(point, point)) - along;
}

/* Fades in proportion to smoothstep of the cosine, over the outer part of the cone. */
static double cone_falloff(const ty_light_def* light, double mu) {
    const double half = light->cone * pi / 360;
    const double outer = cos(half), inner = cos(half * (1 - light->penumbra));
    if (mu <= outer) return 0;
    if (mu >= inner) return 1;
    const double x = (mu - outer) / (inner - outer);
    return x * x * (3 - 2 * x);
}

static double airlight_at(const void* user, double t) {
    const airlight* a = user;
    double point[3], light[3], back[3];
    for (int i = 0; i < 3; ++i) point[i] = a->origin[i] + t * a->way[i];
    double irradiance = 1, distance;
    if (a->light.kind == TY_LIGHT_DIRECTIONAL) {
        memcpy(light, a->light.direction, sizeof light);
        normalize3(light);
    } else {
        for (int i = 0; i < 3; ++i) light[i] = point[i] - a->light.position[i];
        irradiance = 1 / dot3(light, light);
        normalize3(light);
    }
    for (int i = 0; i < 3; ++i) back[i] = -light[i];
    distance = a->light.kind == TY_LIGHT_DIRECTIONAL ? to_surface(a, point, back) : sqrt(1 / irradiance);
    if (a->light.kind == TY_LIGHT_SPOT) {
        double axis[3];
        memcpy(axis, a->light.direction, sizeof axis);
        normalize3(axis);
        irradiance *= cone_falloff(&a->light, dot3(axis, light));
    }
    /* Light along `light` turns into light along -way. */
    const double phase = henyey_greenstein(-dot3(light, a->way), a->g);
    return a->sigma_s * phase * irradiance * (double)a->light.color[0] * exp(-a->sigma_t * (t + distance));
}

/* Rays that begin in the ball and pass the places below a lamp, half of them nearly through its axis. */
static void make_rays(double rays[6 * RAYS], double radius, const double lamp[3]) {
    for (int i = 0; i < RAYS; ++i) {
        double x[4];
        even_point(i, x);
        double* ray = rays + 6 * i;
        for (int a = 0; a < 3; ++a) {
            ray[a] = radius * 1.1 * (x[a] - 0.5);
            ray[3 + a] = lamp[a] + (i % 2 == 0 ? 0.2 : 0.02) * (x[(a + 1) % 4] - 0.5) - ray[a];
        }
        ray[4] -= radius * x[3];
        normalize3(ray + 3);
    }
}

static void check(ty_context* context, const char* what, airlight a, int32_t spp) {
    double rays[6 * RAYS], radiance[3 * RAYS], variance[3 * RAYS];
    ty_scene* scene = new_scene(context);
    const ty_medium_def medium = medium_sphere(a.radius, a.sigma_s, a.sigma_t - a.sigma_s, a.g);
    add_medium(scene, &medium);
    add_light(scene, &a.light);
    commit(scene);
    make_rays(rays, a.radius, a.light.position);
    radiance_along(scene, RAYS, rays, spp, 1, radiance, variance);
    double sum = 0, expected_sum = 0, worst = 0;
    for (int i = 0; i < RAYS; ++i) {
        memcpy(a.origin, rays + 6 * i, sizeof a.origin);
        memcpy(a.way, rays + 6 * i + 3, sizeof a.way);
        const double expected = ty_integrate(airlight_at, &a, 0, to_surface(&a, a.origin, a.way), 4000);
        const double tolerance = fmax(0.01 * expected, 4 * sqrt(variance[3 * i]));
        worst = fmax(worst, fabs(radiance[3 * i] - expected) / fmax(tolerance, 1e-30));
        sum += radiance[3 * i];
        expected_sum += expected;
    }
    printf("%-28s g %4.1f: mean %+.3f%% of 0.5%%, worst of %d rays at %.2f of 1%% or four standard errors\n", what, a.g,
           100 * (sum / expected_sum - 1), RAYS, worst);
    if (!(fabs(sum / expected_sum - 1) < 0.005)) fail_msg("%s: the mean is off by %g", what, sum / expected_sum - 1);
    if (!(worst <= 1)) fail_msg("%s: a ray is off by %g of what is allowed", what, worst);
    ty_scene_destroy(scene);
}

static void sunlight_fades_exactly(void** state) {
    airlight a = {.sigma_s = 0.4, .sigma_t = 0.5, .radius = 1.2, .light = light_of(TY_LIGHT_DIRECTIONAL, 3)};
    set3(a.light.direction, 1, -2, 0.5);
    for (int i = 0; i < 3; i += in_full() ? 1 : 2) {
        a.g = anisotropies[i];
        check(*state, "sunlight in a ball", a, 1 << 15);
    }
    a.sigma_s = a.sigma_t = 6;
    check(*state, "sunlight in a dense ball", a, 1 << 15);
}

static void spot_lights_fade_exactly(void** state) {
    static const double penumbras[] = {0, 0.4};
    airlight a = {.sigma_s = 0.3, .sigma_t = 0.4, .radius = 2, .light = light_of(TY_LIGHT_SPOT, 5)};
    set3(a.light.position, 0.1, 1.8, -0.2);
    set3(a.light.direction, 0, -1, 0);
    a.light.cone = 16;
    for (int i = 0; i < 6; i += in_full() ? 1 : 2) {
        a.g = anisotropies[i % 3];
        a.light.penumbra = penumbras[i / 3];
        check(*state, i < 3 ? "spot, sharp" : "spot, fading", a, 1 << 14);
    }
}

static void point_lights_fade_exactly(void** state) {
    airlight a = {.sigma_s = 0.6, .sigma_t = 0.7, .radius = 2, .light = light_of(TY_LIGHT_POINT, 2)};
    set3(a.light.position, 0.1, 0.3, -0.2);
    for (int i = 0; i < 3; ++i) {
        a.g = anisotropies[i];
        check(*state, "airlight of a point source", a, 1 << 13);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sunlight_fades_exactly),
        cmocka_unit_test(spot_lights_fade_exactly),
        cmocka_unit_test(point_lights_fade_exactly),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
