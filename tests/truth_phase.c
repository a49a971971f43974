/* The Henyey-Greenstein sampler: its distribution, its mean, and that the phase function is normalised. */
#include "truth.h"

#include "scene/media/phase.k.h"

enum { BINS = 64 };

static const double anisotropies[] = {-0.9, -0.5, -0.0005, 0, 0.0005, 0.002, 0.1, 0.5, 0.75, 0.9, 0.96, 0.99};

enum { CASES = sizeof anisotropies / sizeof *anisotropies };

/* Well mixed numbers in [0, 1) (splitmix64). */
static double uniform(uint64_t* state) {
    uint64_t x = *state += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return (double)((x ^ x >> 31) >> 40) * 0x1p-24;
}

/* The fraction of light scattered at cosines below mu. */
static double cumulative(double mu, double g) {
    if (fabs(g) < 1e-4) return 0.5 * (mu + 1) + 0.75 * g * (mu * mu - 1);
    return (1 - g * g) / (2 * g) * (1 / sqrt(1 + g * g - 2 * g * mu) - 1 / (1 + g));
}

/* Chi-square of counts in bins of equal probability, in standard deviations above its mean. */
static double chi_square(const int64_t counts[BINS], int samples) {
    const double expected = (double)samples / BINS;
    double sum = 0;
    for (int i = 0; i < BINS; ++i) sum += pow((double)counts[i] - expected, 2) / expected;
    return (sum - (BINS - 1)) / sqrt(2.0 * (BINS - 1));
}

/* The cosine between two vectors, in double precision. */
static double dot_in_full(ty_vec a, ty_vec b) {
    const double x[3] = {(double)a.x, (double)a.y, (double)a.z}, y[3] = {(double)b.x, (double)b.y, (double)b.z};
    return dot3(x, y) / sqrt(dot3(x, x) * dot3(y, y));
}

static void samples_follow_the_phase_function(void** state) {
    (void)state;
    const ty_vec axis = ty_normalize(ty_vec_make(0.3f, -0.8f, 0.5f));
    ty_vec s, t;
    ty_onb(axis, &s, &t);
    for (int i = 0; i < CASES; ++i) {
        const double g = anisotropies[i];
        /* At 0.99, a sixty-fourth of the light is within a few roundings of a float cosine: fewer samples do not see
         * them. */
        const int samples = fabs(g) > 0.98 ? 1 << 17 : 1 << 20;
        uint64_t random = 12345 + (uint64_t)i;
        int64_t cosines[BINS] = {0}, turns[BINS] = {0}, directions[BINS] = {0};
        double sum = 0, side = 0, length = 0;
        for (int n = 0; n < samples; ++n) {
            const float u = (float)uniform(&random), v = (float)uniform(&random);
            const ty_vec direction = ty_hg_sample(axis, (float)g, u, v);
            const double mu = (double)ty_hg_sample_cosine((float)g, u), along = dot_in_full(direction, axis);
            const double x = (double)ty_dot(direction, s), y = (double)ty_dot(direction, t);
            assert_true(mu >= -1 && mu <= 1);
            ++cosines[(int)fmin(BINS * cumulative(mu, g), BINS - 1)];
            ++directions[(int)fmin(fmax(BINS * cumulative(fmin(along, 1), g), 0), BINS - 1)];
            ++turns[(int)fmin(BINS * (atan2(y, x) / (2 * pi) + 0.5), BINS - 1)];
            sum += mu;
            side += x;
            length = fmax(length, fabs((double)ty_dot(direction, direction) - 1));
        }
        const double spread = sqrt((1 + 2 * g * g) / 3 - g * g), off = (sum / samples - g) * sqrt(samples) / spread;
        const double worst =
            fmax(chi_square(cosines, samples), fmax(chi_square(directions, samples), chi_square(turns, samples)));
        printf("g %7.4f: chi-square of cosine %+.2f, of direction %+.2f, of azimuth %+.2f; mean cosine %+.2f (in "
               "standard deviations)\n",
               g, chi_square(cosines, samples), chi_square(directions, samples), chi_square(turns, samples), off);
        assert_true(worst < 4);
        assert_true(fabs(off) < 4);
        assert_true(fabs(side) < 4 * sqrt(samples * (1 - g * g) / 3));
        assert_true(length < 1e-5);
    }
}

typedef struct moment {
    double g;
    int power;
} moment;

/* In x, 1 - mu = x^2 or 1 + mu = x^2, which spreads the peak. */
static double forwards(const void* user, double x) {
    const moment* m = user;
    return 2 * pi * (double)ty_hg((float)(1 - x * x), (float)m->g) * pow(1 - x * x, m->power) * 2 * x;
}

static double backwards(const void* user, double x) {
    const moment* m = user;
    return 2 * pi * (double)ty_hg((float)(x * x - 1), (float)m->g) * pow(x * x - 1, m->power) * 2 * x;
}

static void the_phase_function_is_normalised(void** state) {
    (void)state;
    for (int i = 0; i < CASES; ++i)
        for (int power = 0; power < 3; ++power) {
            const double g = anisotropies[i], moments[3] = {1, g, (1 + 2 * g * g) / 3};
            const moment m = {g, power};
            const double found = ty_integrate(forwards, &m, 0, 1, 4000) + ty_integrate(backwards, &m, 0, 1, 4000);
            if (!(fabs(found - moments[power]) < 2e-5)) fail_msg("g %g: moment %d is %.7g", g, power, found);
        }
}

static void the_phase_function_has_its_formula(void** state) {
    (void)state;
    for (int i = 0; i < CASES; ++i)
        for (double mu = -1; mu <= 1; mu += 1.0 / 64) {
            const double g = (double)(float)anisotropies[i], expected = henyey_greenstein(mu, g);
            if (!(fabs((double)ty_hg((float)mu, (float)g) / expected - 1) < 2e-5))
                fail_msg("g %g, mu %g: %.7g, not %.7g", g, mu, (double)ty_hg((float)mu, (float)g), expected);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_the_phase_function),
        cmocka_unit_test(the_phase_function_is_normalised),
        cmocka_unit_test(the_phase_function_has_its_formula),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
