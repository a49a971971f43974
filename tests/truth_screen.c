/* Screen-space scattering of a small bright emitter in fog, held against path tracing: how much of the scattered light
 * seems to come from rings around it. */
#include "effort.h"
#include "truth.h"

enum { RINGS = 4, PER_RING = 6, RADIUS_COUNT = RINGS * PER_RING, AZIMUTHS = 24, RAY_COUNT = RADIUS_COUNT * AZIMUTHS };
enum { SIDE = 1400 };

static const double fog_half = 2; /* m: fog on all sides, but not so far that much light would come back from behind */
static const double emitter = 0.04;                       /* its side, m; it is 1 m away */
static const double nearest = 0.03, farthest = 0.03 * 16; /* of all rings, in its plane, m; each is twice the last */
static const double focal = 600;                          /* pixels */

/* The middle of a part of a ring; parts are evenly wide on a log scale. */
static double radius_at(double part) {
    return nearest * pow(farthest / nearest, (part + 0.5) / RADIUS_COUNT);
}

/* Path tracing's energy in each ring, over 1 - exp(-thickness) of what the emitter would send. */
static void trace_energy(ty_context* context, double thickness, double g, double energy[RINGS]) {
    double *rays = new_numbers(6 * RAY_COUNT), *radiance = new_numbers(3 * RAY_COUNT);
    ty_scene* scene = emitter_in_fog(context, emitter, fog_half, thickness, g);
    for (int i = 0; i < RAY_COUNT; ++i) {
        const double radius = radius_at(i / AZIMUTHS), turn = 2 * pi * (i % AZIMUTHS + 0.5) / AZIMUTHS;
        set3(rays + 6 * i + 3, radius * cos(turn), radius * sin(turn), -1);
    }
    radiance_along(scene, RAY_COUNT, rays, 1024, 0, radiance, NULL);
    ty_scene_destroy(scene);
    for (int ring = 0; ring < RINGS; ++ring) energy[ring] = 0;
    for (int i = 0; i < 3 * RAY_COUNT; ++i) {
        const int part = i / (3 * AZIMUTHS);
        const double inner = radius_at(part - 0.5), outer = radius_at(part + 0.5);
        energy[part / PER_RING] += pi * (outer * outer - inner * inner) * radiance[i] / (3 * AZIMUTHS) /
                                   (emitter * emitter * -expm1(-thickness));
    }
    free(radiance);
    free(rays);
}

/* The same of ty_screen_apply: the emitter is a square of pixels in a picture whose distances are the emitter's. */
static void apply_energy(ty_context* context, double thickness, double g, ty_screen_spread spread,
                         double energy[RINGS]) {
    const int64_t pixels = (int64_t)SIDE * SIDE;
    float* planes = calloc((size_t)(7 * pixels), sizeof *planes); /* color, out, distance */
    assert_non_null(planes);
    const int half = (int)(emitter * focal / 2);
    double whole = 0;
    for (int64_t i = 0; i < pixels; ++i) {
        const int x = (int)(i % SIDE) - SIDE / 2, y = (int)(i / SIDE) - SIDE / 2;
        const bool lit = x >= -half && x < half && y >= -half && y < half;
        for (int c = 0; c < 3; ++c) planes[c * pixels + i] = lit ? 1.0f : 0.0f;
        whole += lit ? -expm1(-thickness) : 0;
        planes[6 * pixels + i] = 1;
    }
    ty_screen_image image = ty_default_screen_image();
    image.width = SIDE;
    image.height = SIDE;
    image.distance = planes + 6 * pixels;
    image.color.row = image.out.row = image.distance_row = SIDE;
    for (int c = 0; c < 3; ++c) {
        image.color.data[c] = planes + c * pixels;
        image.out.data[c] = planes + (3 + c) * pixels;
    }
    ty_screen_def def = ty_default_screen_def();
    gray(def.sigma_s, thickness);
    gray(def.g, g);
    def.focal[0] = def.focal[1] = focal;
    def.spread = spread;
    def.levels = TY_SCREEN_LEVELS_MAX;
    must(context, ty_screen_apply(context, &def, &image, NULL, 0, NULL));
    for (int ring = 0; ring < RINGS; ++ring) energy[ring] = 0;
    for (int64_t i = 0; i < pixels; ++i) {
        const double away = hypot((double)(i % SIDE) - SIDE / 2.0 + 0.5, (double)(i / SIDE) - SIDE / 2.0 + 0.5) / focal;
        const double ring = log2(fmax(away, 1e-6) / nearest);
        if (ring >= 0 && ring < RINGS) energy[(int)ring] += (double)image.out.data[1][i] / whole;
    }
    free(planes);
}

static double root_mean_square(const double a[RINGS], const double b[RINGS]) {
    double sum = 0;
    for (int i = 0; i < RINGS; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum / RINGS);
}

/* tolerance: of the root mean square difference to path; gain: how many times larger the Gaussian's is at least. */
static void check(ty_context* context, double thickness, double g, double tolerance, double gain) {
    double path[RINGS], small[RINGS], gaussian[RINGS];
    trace_energy(context, thickness, g, path);
    apply_energy(context, thickness, g, TY_SCREEN_SPREAD_SMALL_ANGLE, small);
    apply_energy(context, thickness, g, TY_SCREEN_SPREAD_GAUSSIAN, gaussian);
    for (int i = 0; i < RINGS; ++i)
        printf("thickness %g, g %g, ring %d: path %.3f, small angles %.3f, Gaussian %.3f\n", thickness, g, i, path[i],
               small[i], gaussian[i]);
    const double error = root_mean_square(small, path), other = root_mean_square(gaussian, path);
    printf("thickness %g, g %g: rms %.4f, Gaussian %.4f, %.1f times as much\n", thickness, g, error, other,
           other / error);
    assert_true(error < tolerance);
    assert_true(other > gain * error);
}

static void strongly_forward_fog_is_met(void** state) {
    if (in_full()) check(*state, 1, 0.97, 0.01, 15);
    if (in_full()) check(*state, 2, 0.97, 0.02, 8);
    check(*state, 4, 0.97, 0.03, 4);
}

/* In thick fog that scatters by larger angles, much light arrives that no small angle explains. */
static void forward_fog_is_met_while_thin(void** state) {
    check(*state, 1, 0.9, 0.025, 4);
    if (in_full()) check(*state, 2, 0.9, 0.04, 2.5);
    if (in_full()) check(*state, 4, 0.9, 0.1, 0.5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strongly_forward_fog_is_met),
        cmocka_unit_test(forward_fog_is_met_while_thin),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
