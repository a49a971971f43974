/* Densities about lamps: each is that of its samples, down to the angles that matter beside a lamp. */
#include "effort.h"
#include "method/path/trace/point_light_direction.k.h"
#include "scene/media/phase.k.h"

#include <math.h>

static const float cosines[] = {0, 0.3f, 0.7f, 0.9f, 0.96f, 0.98f};

enum { COSINES = sizeof cosines / sizeof *cosines, DRAWS = 20000 };

static double angle_between(ty_vec a, ty_vec b) {
    const double x[3] = {(double)a.x, (double)a.y, (double)a.z}, y[3] = {(double)b.x, (double)b.y, (double)b.z};
    double across = 0, along = 0;
    for (int i = 0; i < 3; ++i) {
        const double cross = x[(i + 1) % 3] * y[(i + 2) % 3] - x[(i + 2) % 3] * y[(i + 1) % 3];
        across += cross * cross;
        along += x[i] * y[i];
    }
    return atan2(sqrt(across), along);
}

/* The share of Henyey-Greenstein scattering within an angle, without cancellation. */
static double share_within(double angle, double g) {
    const double tilt = 2 * sin(angle / 2) * sin(angle / 2), less = 1 - g, root = sqrt(less * less + 2 * g * tilt);
    return (1 + g) * tilt / (root * (root + less));
}

/* u is the share of light within the sampled angle, for u down to 2^-40. */
static void narrow_lobes_are_henyey_greenstein(void** state) {
    (void)state;
    const ty_vec axes[] = {ty_vec_make(0, 0, 1), ty_normalize(ty_vec_make(0.3f, -0.8f, 0.5f))};
    for (int axis = 0; axis < 2; ++axis)
        for (int i = 1; i < COSINES; ++i)
            for (int k = 0; k <= 160; ++k) {
                const double u = exp2(-0.25 * (k + 0.5)), g = (double)cosines[i];
                const ty_vec direction = ty_hg_sample_narrow(axes[axis], cosines[i], (float)u, (float)k / 161);
                const double angle = angle_between(axes[axis], direction);
                assert_true(fabs((double)ty_dot(direction, direction) - 1) < 1e-5);
                const double low = share_within(fmax(angle - 2e-7, 0), g), high = share_within(angle + 2e-7, g);
                /* 1 - u has 24 bits in the last part of the distribution. */
                if (!(u > low * (1 - 1e-4) - 1e-12 && u < high * (1 + 1e-4)))
                    fail_msg("g %g, u %g: share of angle %g is %g", g, u, angle, share_within(angle, g));
            }
}

typedef struct distance_draw {
    double t, pdf;
} distance_draw;

static int by_distance(const void* a, const void* b) {
    const double x = ((const distance_draw*)a)->t, y = ((const distance_draw*)b)->t;
    return (x > y) - (x < y);
}

/* The density holds all of the probability between the samples, and the mean of 1 / pdf is the interval. */
static void distances_have_their_density(void** state) {
    (void)state;
    static const struct {
        float enter, leave, closest, distance;
    } cases[] = {{0, 3, 1.2f, 0.5f}, {0, 3, 1.2f, 0.1f},  {0.5f, 2, 4, 0.3f}, {2, 9, 1, 0.2f},
                 {0, 8, -1, 0.5f},   {1, 1.1f, 1, 1e-2f}, {0, 1, 0.5f, 50},   {0, 200, 3, 1}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c)
        for (int i = 0; i < 4 * COSINES; ++i) {
            const float uniform = i < 2 * COSINES ? 0.0f : 0.5f;
            const float g = i % 2 == 0 ? cosines[i / 2 % COSINES] : -cosines[i / 2 % COSINES];
            const ty_media_interval interval = {cases[c].enter, cases[c].leave};
            const ty_closest_approach closest = {cases[c].closest, cases[c].distance * cases[c].distance, 1};
            static distance_draw draws[DRAWS];
            double sum = 0, inverse = 0;
            for (int n = 0; n < DRAWS; ++n) {
                float t;
                const float u = ((float)n + 0.5f) / DRAWS;
                draws[n].pdf = (double)ty_point_light_distance_sample(interval, &closest, g, uniform, u, &t);
                draws[n].t = (double)t;
                assert_true(draws[n].pdf > 0 && t >= interval.enter && t <= interval.leave);
                inverse += 1 / draws[n].pdf / DRAWS;
            }
            qsort(draws, DRAWS, sizeof *draws, by_distance);
            for (int n = 1; n < DRAWS; ++n)
                sum += 0.5 * (draws[n].t - draws[n - 1].t) * (draws[n].pdf + draws[n - 1].pdf);
            const double length = (double)interval.leave - (double)interval.enter;
            if (fabs(sum - 1) > 0.01 || fabs(inverse / length - 1) > 0.02)
                fail_msg("case %d, g %g: the density holds %g, and spans %g of %g m", (int)c, (double)g, sum, inverse,
                         length);
        }
}

/* The mean of 1 / pdf is the sphere, and half of the samples lie within the median of c(theta, g). */
static void directions_have_their_density(void** state) {
    (void)state;
    const ty_vec origin = ty_vec_make(0.5f, -1, 2), lamp = ty_vec_make(1, 1, 1);
    for (int i = 0; i < COSINES; ++i) {
        const double g = (double)cosines[i], median = 2 * atan((1 - g) / (1 + g));
        double sphere = 0;
        int within = 0;
        for (int n = 0; n < DRAWS; ++n) {
            const float u = ((float)n + 0.5f) / DRAWS, turn = (float)((n * 7919) % DRAWS) / DRAWS;
            const ty_vec direction = ty_point_light_direction_sample(origin, lamp, cosines[i], u, turn);
            const ty_closest_approach closest = ty_closest_approach_find(origin, direction, lamp, 1e-4f);
            const double pdf = (double)ty_point_light_direction_pdf(&closest, cosines[i]);
            assert_true(pdf > 0 && fabs((double)ty_dot(direction, direction) - 1) < 1e-5);
            sphere += 1 / pdf / DRAWS;
            within += angle_between(ty_sub(lamp, origin), direction) < median;
        }
        if (fabs(sphere / (4 * TY_PI_F64) - 1) > 0.005 || abs(2 * within - DRAWS) > DRAWS / 500)
            fail_msg("g %g: the mean of 1 / pdf is %g, %d of %d samples within the median", g, sphere, within, DRAWS);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(narrow_lobes_are_henyey_greenstein),
                                       cmocka_unit_test(distances_have_their_density),
                                       cmocka_unit_test(directions_have_their_density)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
