/* The spread of a small bright emitter's image in fog: path tracing against the widths that screen-space scattering can
 * take it to have. */
#define _DEFAULT_SOURCE
#include "truth.h"

enum { RADIUS_COUNT = 40, AZIMUTHS = 16, RAY_COUNT = RADIUS_COUNT * AZIMUTHS, CHECKED = 5 };

static const double fog_half = 3;                    /* m: fog on all sides */
static const double side = 0.01;                     /* of the emitter, m; it is 1 m away */
static const double nearest = 0.008, farthest = 1.0; /* radii in the emitter's plane, m */
static const double checked[CHECKED] = {0.02, 0.05, 0.1, 0.2, 0.3};

static double radius_at(int i) {
    return nearest * pow(farthest / nearest, i / (RADIUS_COUNT - 1.0));
}

/* The scattered light that seems to come from within each radius, over (1 - exp(-thickness)) of what the lamp sends
 * unscattered: what of the scattered part a point spread function has there. */
static void measure_energy(ty_context* context, double thickness, double g, int32_t spp, double energy[RADIUS_COUNT]) {
    double *rays = new_numbers(6 * RAY_COUNT), *radiance = new_numbers(3 * RAY_COUNT), profile[RADIUS_COUNT] = {0};
    ty_scene* scene = emitter_in_fog(context, side, fog_half, thickness, g);
    for (int i = 0; i < RAY_COUNT; ++i) {
        const double radius = radius_at(i / AZIMUTHS), turn = 2 * pi * (i % AZIMUTHS + 0.5) / AZIMUTHS;
        set3(rays + 6 * i + 3, radius * cos(turn), radius * sin(turn), -1);
    }
    radiance_along(scene, RAY_COUNT, rays, spp, 0, radiance, NULL);
    for (int i = 0; i < 3 * RAY_COUNT; ++i) profile[i / (3 * AZIMUTHS)] += radiance[i] / (3 * AZIMUTHS);
    ty_scene_destroy(scene);
    free(radiance);
    free(rays);
    /* Within the smallest radius the profile falls as 1 / r. */
    const double whole = side * side * -expm1(-thickness), step = log(farthest / nearest) / (RADIUS_COUNT - 1);
    energy[0] = 2 * pi * nearest * nearest * profile[0] / whole;
    for (int i = 1; i < RADIUS_COUNT; ++i) {
        const double a = radius_at(i - 1), b = radius_at(i);
        energy[i] = energy[i - 1] + pi * step * (a * a * profile[i - 1] + b * b * profile[i]) / whole;
    }
}

static double energy_within(const double energy[RADIUS_COUNT], double radius) {
    const double at = log(radius / nearest) / log(farthest / nearest) * (RADIUS_COUNT - 1);
    const int i = (int)at;
    return energy[i] + (at - i) * (energy[i + 1] - energy[i]);
}

/* A Gaussian's, with a share of the variance per axis thickness (1 - g) that beams have after 1 m. */
static double gaussian_energy(double thickness, double g, double share, double radius) {
    return -expm1(-radius * radius / (2 * share * thickness * (1 - g)));
}

/* Beams that scatter often by small angles: Henyey-Greenstein is then a Cauchy kernel with transform exp(-a k), a =
 * (1 - g) / sqrt(g), so the transfer function of the scattered part has a closed form. */
typedef struct small_angles {
    double thickness, a, radius;
} small_angles;

static double small_angle_term(const void* user, double k) {
    const small_angles* s = user;
    const double x = s->a * k, passed = x > 1e-9 ? -expm1(-x) / x : 1, blur = 0.02 * s->radius * k;
    return s->radius * j1(k * s->radius) * expm1(s->thickness * passed) / expm1(s->thickness) * exp(-blur * blur / 2);
}

static double small_angle_energy(double thickness, double g, double radius) {
    const small_angles s = {thickness, (1 - g) / sqrt(g), radius};
    return ty_integrate(small_angle_term, &s, 0, 250 / radius, 400);
}

static double root_mean_square(const double errors[CHECKED]) {
    double sum = 0;
    for (int i = 0; i < CHECKED; ++i) sum += errors[i] * errors[i];
    return sqrt(sum / CHECKED);
}

static void check(ty_context* context, double thickness, double g, int32_t spp) {
    double energy[RADIUS_COUNT], eighth[CHECKED], third[CHECKED], closed[CHECKED];
    measure_energy(context, thickness, g, spp, energy);
    for (int i = 0; i < CHECKED; ++i) {
        const double path = energy_within(energy, checked[i]), form = small_angle_energy(thickness, g, checked[i]);
        printf("thickness %g, g %g, radius %.2f: path %.3f, small angles %.3f, Eq. 2 %.3f, 1/3 %.3f\n", thickness, g,
               checked[i], path, form, gaussian_energy(thickness, g, 1.0 / 8, checked[i]),
               gaussian_energy(thickness, g, 1.0 / 3, checked[i]));
        closed[i] = form - path;
        eighth[i] = gaussian_energy(thickness, g, 1.0 / 8, checked[i]) - path;
        third[i] = gaussian_energy(thickness, g, 1.0 / 3, checked[i]) - path;
    }
    assert_true(root_mean_square(closed) < 0.05);
    assert_true(root_mean_square(closed) < 0.7 * root_mean_square(eighth));
    assert_true(root_mean_square(eighth) < 0.8 * root_mean_square(third));
}

static void small_emitters_spread_as_measured(void** state) {
    check(*state, 1, 0.9, 256);
    check(*state, 2, 0.9, 256);
    check(*state, 1, 0.97, 256);
    check(*state, 2, 0.97, 256);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(small_emitters_spread_as_measured)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
