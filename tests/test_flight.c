/* Free flights through homogeneous media: what is stopped, and where, in thin media and in thick. */
#include "checks.h"

#include "method/path/trace/collision.k.h"

static void stopping_is_precise(void** state) {
    (void)state;
    for (double depth = 1e-30; depth < 80; depth *= 1.07) {
        const double expected = -expm1(-(double)(float)depth);
        assert_close((double)ty_collision_probability((float)depth) / expected, 1, 3e-6);
    }
    assert_close(ty_collision_probability(0), 0, 0);
    for (double fraction = 1e-30; fraction < 0.99; fraction *= 1.07) {
        const double expected = -log1p(-(double)(float)fraction);
        assert_close((double)ty_sample_collision_depth((float)fraction) / expected, 1, 5e-6);
    }
}

/* In two media of which one begins later, whatever their depth: the share of light that scatters, and its mean place
 * by quadrature. */
static void flights_follow_the_density(void** state) {
    (void)state;
    static const double depths[] = {1e-9, 1e-6, 1e-3, 0.02, 0.04, 1, 8};
    for (int i = 0; i < 7; ++i) {
        const double sigma[2] = {depths[i], depths[i] / 2};
        ty_medium_view media[2];
        ty_spans spans = {.count = 2, .medium = {0, 1}, .enter = {1, 1.5f}, .leave = {2, 3}};
        memset(media, 0, sizeof media);
        for (int m = 0; m < 2; ++m)
            for (int c = 0; c < 3; ++c) {
                media[m].sigma_t[c] = (float)sigma[m];
                media[m].sigma_s[c] = (float)(sigma[m] * (m == 0 ? 0.8 : 0.5));
            }
        double depth = 0, scattered = 0, place = 0;
        enum { STEPS = 20000 };
        for (int s = 0; s < STEPS; ++s) {
            const double t = 1 + (s + 0.5) * 2 / STEPS, first = t < 2 ? sigma[0] : 0, second = t > 1.5 ? sigma[1] : 0;
            const double weight = exp(-depth) * (0.8 * first + 0.5 * second) * 2 / STEPS;
            depth += (first + second) * 2 / STEPS;
            scattered += weight;
            place += weight * t;
        }
        const double all = sigma[0] + 1.5 * sigma[1];
        const float stopped[3] = {ty_collision_probability((float)all), ty_collision_probability((float)all),
                                  ty_collision_probability((float)all)};
        double sum = 0, mean = 0;
        enum { SAMPLES = 40000 };
        ty_sampler random = {0};
        for (int s = 0; s < SAMPLES; ++s) {
            float beta[3] = {1, 1, 1};
            ty_collision collision;
            if (!ty_sample_homogeneous_collision(media, &spans, stopped, (float)((s + 0.5) / SAMPLES), &random, beta,
                                                 &collision))
                continue;
            assert_true(collision.t >= 1 && collision.t <= 3);
            sum += (double)beta[0] / SAMPLES;
            mean += (double)beta[0] * (double)collision.t / SAMPLES;
        }
        assert_close(sum / scattered, 1, 2e-3);
        assert_close(mean / place, 1, 2e-3);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stopping_is_precise),
        cmocka_unit_test(flights_follow_the_density),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
