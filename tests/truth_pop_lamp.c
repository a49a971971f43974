/* Fluence about a lamp in a ball of fog by principal ordinates, by the distance to the lamp, against light that is
 * followed from the lamp scattering by scattering. */
#include "truth.h"

#include <stdio.h>
#include <string.h>

enum { RADII = 24, COSINES = 5 };

static const double anisotropies[COSINES] = {0, 0.5, 0.7, 0.9, 0.96};
static const double radius = 2.5, width = 0.1;

static uint64_t state_of_random = 1;

static double uniform(void) {
    uint64_t z = state_of_random += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) / 9007199254740992.0;
}

/* Adds the length of a flight in each shell, by the distances at which it crosses their bounds. */
static void add_flight(const double x[3], const double w[3], double length, double weight, double sums[RADII]) {
    const double b = dot3(x, w), c = dot3(x, x);
    for (int i = 0; i < RADII; ++i) {
        double inside[2];
        for (int k = 0; k < 2; ++k) {
            const double r = width * (i + k), d = b * b - c + r * r, root = d > 0 ? sqrt(d) : 0;
            const double from = fmax(0, -b - root), to = fmin(length, -b + root);
            inside[k] = d > 0 && to > from ? to - from : 0;
        }
        sums[i] += weight * (inside[1] - inside[0]);
    }
}

static void turn(double w[3], double g) {
    const double u = uniform(), phi = 2 * pi * uniform();
    const double s = (1 - g * g) / (1 - g + 2 * g * u), mu = g == 0 ? 1 - 2 * u : (1 + g * g - s * s) / (2 * g);
    const double sine = sqrt(fmax(0, 1 - mu * mu)), axis[3] = {fabs(w[0]) < 0.5, fabs(w[0]) >= 0.5, 0};
    double a[3], b[3];
    cross3(w, axis, a);
    normalize3(a);
    cross3(w, a, b);
    for (int i = 0; i < 3; ++i) w[i] = mu * w[i] + sine * (cos(phi) * a[i] + sin(phi) * b[i]);
}

/* Fluence of a lamp of 1 W/sr in a ball, in shells: the mean length of flights in each over its volume. */
static void simulate(double sigma_s, double sigma_a, double g, int32_t photons, double fluence[RADII]) {
    double sums[RADII] = {0};
    for (int32_t n = 0; n < photons; ++n) {
        double x[3] = {0, 0, 0}, w[3], weight = 1;
        const double mu = 1 - 2 * uniform(), phi = 2 * pi * uniform();
        set3(w, sqrt(1 - mu * mu) * cos(phi), sqrt(1 - mu * mu) * sin(phi), mu);
        while (weight > 1e-4) {
            const double b = dot3(x, w), end = -b + sqrt(fmax(0, b * b - dot3(x, x) + radius * radius));
            const double t = -log(uniform()) / (sigma_s + sigma_a);
            add_flight(x, w, fmin(t, end), weight, sums);
            if (t >= end) break;
            for (int a = 0; a < 3; ++a) x[a] += t * w[a];
            weight *= sigma_s / (sigma_s + sigma_a);
            turn(w, g);
        }
    }
    for (int i = 0; i < RADII; ++i) {
        const double inner = width * i, outer = inner + width;
        fluence[i] = 4 * pi * sums[i] / photons / (4 * pi / 3 * (outer * outer * outer - inner * inner * inner));
    }
}

/* A ball with a reduced scattering coefficient of 1/m. */
static ty_scene* lamp_in_a_ball(ty_context* context, double g, double albedo) {
    ty_scene* scene = new_scene(context);
    const double sigma_s = 1 / (1 - g);
    const ty_medium_def ball = medium_sphere(radius, sigma_s, sigma_s * (1 / albedo - 1), g);
    add_medium(scene, &ball);
    const ty_light_def lamp = light_of(TY_LIGHT_POINT, 1);
    add_light(scene, &lamp);
    set_camera(scene, 0, 0, 8, 45);
    commit(scene);
    return scene;
}

/* Fluence of cells as wide as the shells, averaged over those whose centers are in each. */
static void pop_fluence(const ty_scene* scene, double max_flux, double fluence[RADII]) {
    enum { SIDE = 2 * RADII };
    static double cells[SIDE * SIDE * SIDE][3];
    static const int32_t size[3] = {SIDE, SIDE, SIDE};
    const double half = width * RADII, lower[3] = {-half, -half, -half}, upper[3] = {half, half, half};
    double count[RADII] = {0};
    ty_pop_def def = ty_default_pop_def();
    ty_pop* light = NULL;
    def.width = def.height = 16;
    def.max_flux_fraction = max_flux;
    must(ty_scene_context(scene), ty_pop_solve(scene, &def, &light, NULL));
    must(ty_scene_context(scene), ty_pop_fluence(light, lower, upper, size, cells[0], NULL));
    ty_pop_destroy(light);
    memset(fluence, 0, RADII * sizeof *fluence);
    for (int i = 0; i < SIDE * SIDE * SIDE; ++i) {
        const double at[3] = {i % SIDE + 0.5 - RADII, i / SIDE % SIDE + 0.5 - RADII, i / SIDE / SIDE + 0.5 - RADII};
        const int shell = (int)sqrt(dot3(at, at));
        if (shell >= RADII) continue;
        /* To the middle of the shell, by the inverse square law. */
        fluence[shell] += cells[i][1] * dot3(at, at) / ((shell + 0.5) * (shell + 0.5));
        count[shell] += 1;
    }
    for (int i = 0; i < RADII; ++i) fluence[i] /= fmax(1, count[i]);
}

enum { PRINTED = RADII / 2 };

/* Ratios at every other shell, with max_flux <= 0 for the automatic one. */
static void find_ratios(ty_context* context, double g, double albedo, double max_flux, int32_t photons,
                        double ratio[PRINTED]) {
    double truth[RADII], is[RADII];
    ty_scene* scene = lamp_in_a_ball(context, g, albedo);
    simulate(1 / (1 - g), (1 / albedo - 1) / (1 - g), g, photons, truth);
    pop_fluence(scene, max_flux > 0 ? max_flux : TY_AUTO, is);
    printf("g %.2f:", g);
    for (int i = 0; i < PRINTED; ++i) printf(" %.3f", ratio[i] = is[2 * i + 1] / truth[2 * i + 1]);
    printf("\n");
    ty_scene_destroy(scene);
}

/* 0.15 m from the lamp, 0.35, 0.55 .. 2.35 m. The aim is 0.05, which g = 0.9 and 0.96 keep to but for the last. Flights
 * of 20000 photons leave a noise of 0.01. */
static void fluence_about_a_lamp(void** state) {
    static const double measured[COSINES][PRINTED] = {
        {0.930, 0.857, 0.857, 0.893, 0.932, 0.968, 0.989, 1.017, 1.036, 1.046, 1.043, 1.022},
        {0.980, 0.918, 0.927, 0.956, 0.980, 0.993, 1.029, 1.034, 1.039, 1.035, 0.999, 0.973},
        {0.994, 0.944, 0.939, 0.966, 0.987, 0.995, 1.022, 1.034, 1.035, 1.027, 1.005, 0.950},
        {1.009, 0.956, 0.958, 0.996, 0.999, 1.009, 1.017, 1.030, 1.013, 1.018, 0.983, 0.931},
        {1.009, 0.972, 0.966, 0.985, 1.005, 1.017, 1.033, 1.029, 1.024, 1.015, 1.000, 0.935},
    };
    double worst = 0, ratio[PRINTED];
    for (int i = 0; i < COSINES; ++i) {
        if (!in_full() && i % 3 != 0) continue;
        find_ratios(*state, anisotropies[i], 1, 0, 20000, ratio);
        for (int r = 0; r < PRINTED; ++r) worst = fmax(worst, fabs(ratio[r] - measured[i][r]));
    }
    assert_true(worst < 0.03);
}

/* `truth_pop_lamp PHOTONS ALBEDO MAX_FLUX` prints ratios. */
int main(int argc, char** argv) {
    if (argc > 3) {
        double ratio[PRINTED];
        ty_context* context = truth_context(TY_AUTO);
        for (int i = 0; i < COSINES; ++i)
            find_ratios(context, anisotropies[i], atof(argv[2]), atof(argv[3]), atoi(argv[1]), ratio);
        ty_context_destroy(context);
        return 0;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(fluence_about_a_lamp)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
