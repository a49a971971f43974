/* Phase functions: that they are normalised, have the published mean cosines, and are sampled as they are evaluated;
 * Legendre moments against quadrature; refusals. */
#include "checks.h"

#include "base/legendre.k.h"
#include "base/quadrature.h"
#include "scene/media/phase.h"
#include "scene/media/phase_fit.h"

#include <stdio.h>

static const double pi = 3.14159265358979323846;

static const double coarse_cosines[] = {-1, -0.5, 0.2, 0.9, 1}, coarse_values[] = {2, 1, 0, 3, 50};
static const double close_cosines[] = {1, 1 - 1e-15, 0, -1 + 1e-12, -1}, close_values[] = {9, 4, 1, 1, 0};
static const double falling_cosines[] = {1, 0, -1}, falling_values[] = {4, 1, 0};

typedef struct named_phase {
    const char* name;
    int32_t count;
    ty_phase_lobe lobes[3];
    double mean;      /* published mean cosine */
    double tolerance; /* of the mean */
} named_phase;

#define DRAINE(weight_, g_, alpha_)                                                                                    \
    { .kind = TY_PHASE_DRAINE, .weight = {weight_, weight_, weight_}, .g = g_, .alpha = alpha_ }
#define MIE(diameter_)                                                                                                 \
    { .kind = TY_PHASE_MIE, .weight = {1, 1, 1}, .diameter = diameter_ }
#define FORAND(...)                                                                                                    \
    { .kind = TY_PHASE_FOURNIER_FORAND, .weight = {1, 1, 1}, __VA_ARGS__ }
#define TABLE(name)                                                                                                    \
    {                                                                                                                  \
        .kind = TY_PHASE_TABLE, .weight = {1, 1, 1}, .cosines = name##_cosines, .values = name##_values,               \
        .count = sizeof name##_cosines / sizeof name##_cosines[0]                                                      \
    }

/* The mean cosine of Draine (2003), Eq. 6. */
static double draine_mean(double g, double alpha) {
    return g * (1 + alpha * (3 + 2 * g * g) / 5) / (1 + alpha * (1 + 2 * g * g) / 3);
}

/* Mean cosines: of Henyey-Greenstein g, of Draine (2003) his Eq. 6 and of Rayleigh 0; of mie 10 that of the brute-force
 * reference; of the tables by hand. Fournier and Forand's B of 1.83 % is that of Mobley, Sundman and Boss (2002), whose
 * particles of Petzold have 0.924 (Mobley 1994). */
static const named_phase phases[] = {
    {"hg -0.4", 1, {DRAINE(1, -0.4, 0)}, -0.4, 1e-6},
    {"hg 0.95", 1, {DRAINE(2, 0.95, 0)}, 0.95, 1e-6},
    {"rayleigh", 1, {DRAINE(1, 0, 1)}, 0, 1e-6},
    {"two lobes", 2, {DRAINE(9, 0.85, 0), DRAINE(1, -0.3, 0)}, 0.735, 1e-6},
    {"draine 0.6 20", 1, {DRAINE(1, 0.6, 20)}, 0.7642781, 1e-6},
    {"draine -0.7 1000", 1, {DRAINE(1, -0.7, 1000)}, -0.8440242, 1e-6},
    {"mie 0.05", 1, {MIE(0.05)}, 0.037377, 1e-5},
    {"mie 1", 1, {MIE(1)}, 0.824053, 1e-5},
    {"mie 3", 1, {MIE(3)}, 0.813869, 1e-5},
    {"mie 10", 1, {MIE(10)}, 0.864164, 1e-5},
    {"mie 50", 1, {MIE(50)}, 0.891194, 1e-5},
    {"petzold", 1, {FORAND(.n = 1.10, .mu = 3.5835)}, 0.924, 0.01},
    {"backscatter", 1, {FORAND(.backscatter = 0.03)}, 0.9, 0.02},
    {"table", 1, {TABLE(coarse)}, 0.5375, 1e-6},
    {"falling", 1, {TABLE(falling)}, 4.0 / 9, 1e-6},
    {"close", 1, {TABLE(close)}, 0.2857143, 1e-6},
    {"mixed", 3, {DRAINE(1, 0.3, 2), MIE(20), TABLE(coarse)}, 0.6, 0.3},
};

enum { PHASES = sizeof phases / sizeof phases[0] };

static ty_phase_view* view_of(ty_context* context, const named_phase* phase) {
    ty_phase_view* view = NULL;
    assert_int_equal(ty_phase_check(context, "phase", phase->lobes, phase->count), TY_OK);
    assert_int_equal(ty_phase_view_create(context, phase->lobes, phase->count, &view), TY_OK);
    return view;
}

typedef struct integrand {
    const ty_phase_view* view;
    int32_t order;
} integrand;

/* A Legendre moment's integrand over the logarithm of the tilt. The value is that of the kernel, with the tilt in place
 * of a rounded cosine for tables. */
static double moment_at(const void* user, double x) {
    const integrand* m = user;
    const double tilt = exp(x), mu = 1 - tilt;
    double value = 0, before = 0, now = 1;
    for (int32_t i = 0; i < m->view->count; ++i) {
        const ty_phase_term* term = &m->view->terms[i];
        const double g = (double)term->g, alpha = (double)term->alpha, base = (1 - g) * (1 - g) + 2 * g * tilt;
        const double one = term->node_count > 0 ? (double)ty_phase_table_value(term, (float)tilt)
                                                : (1 - g * g) / (4 * pi * base * sqrt(base)) * (1 + alpha * mu * mu) *
                                                      3 / (3 + alpha * (1 + 2 * g * g));
        value += (double)term->weight[1] * one;
    }
    for (int32_t l = 0; l < m->order; ++l) {
        const double next = ty_legendre_next_f64(l, mu, now, before);
        before = now;
        now = next;
    }
    return 2 * pi * tilt * value * now;
}

static double moment_by_quadrature(const ty_phase_view* view, int32_t order) {
    const integrand m = {view, order};
    return ty_integrate(moment_at, &m, log(1e-13), log(2), 4000);
}

static void functions_are_normalised(void** state) {
    for (int i = 0; i < PHASES; ++i) {
        ty_phase_view* view = view_of(*state, &phases[i]);
        const double sum = moment_by_quadrature(view, 0), mean = moment_by_quadrature(view, 1);
        if (!(fabs(sum - 1) < 2e-5)) fail_msg("%s integrates to %.7f", phases[i].name, sum);
        if (!(fabs(mean - phases[i].mean) <= phases[i].tolerance + 2e-5))
            fail_msg("%s has the mean cosine %.7f", phases[i].name, mean);
        assert_close(view->moments[1][0], 1, 1e-5);
        assert_close(view->moments[1][1], mean, 2e-5);
        ty_phase_view_destroy(*state, view);
    }
    assert_close(draine_mean(0.6, 20), 0.7642781, 1e-7);
    assert_close(draine_mean(-0.7, 1000), -0.8440242, 1e-7);
}

static void moments_are_those_of_quadrature(void** state) {
    for (int i = 0; i < PHASES; ++i) {
        ty_phase_view* view = view_of(*state, &phases[i]);
        for (int32_t l = 0; l < TY_PHASE_MOMENTS; ++l) {
            const double expected = moment_by_quadrature(view, l);
            if (!(fabs((double)view->moments[1][l] - expected) < 3e-5))
                fail_msg("%s, l = %d: %.7f, not %.7f", phases[i].name, l, (double)view->moments[1][l], expected);
        }
        ty_phase_view_destroy(*state, view);
    }
}

/* Kernels evaluate the formulas: Henyey-Greenstein, Rayleigh, and Fournier and Forand between nodes. */
static void values_are_the_formulas(void** state) {
    const double cosines[] = {-1, -0.7, 0, 0.3, 0.99, 1};
    const ty_phase_lobe rayleigh = DRAINE(1, 0, 1), hg = DRAINE(1, 0.8, 0), petzold = FORAND(.n = 1.10, .mu = 3.5835);
    float values[18];
    assert_int_equal(ty_phase_values(*state, &rayleigh, 1, 6, cosines, values), TY_OK);
    for (int i = 0; i < 6; ++i) assert_close(values[3 * i], 3 / (16 * pi) * (1 + cosines[i] * cosines[i]), 1e-7);
    assert_int_equal(ty_phase_values(*state, &hg, 1, 6, cosines, values), TY_OK);
    for (int i = 0; i < 6; ++i) assert_close(values[3 * i + 2] / (float)ty_hg_f64(cosines[i], 0.8), 1, 1e-6);
    assert_int_equal(ty_phase_values(*state, &petzold, 1, 5, cosines, values), TY_OK);
    for (int i = 0; i < 5; ++i)
        assert_close((double)values[3 * i + 1] / ty_fournier_forand(1.10, 3.5835, 1 - cosines[i]), 1, 1e-3);
    assert_close(ty_fournier_forand_backscatter(1.10, 3.5835), 0.0183, 5e-5);
    assert_close(ty_fournier_forand_backscatter(ty_fournier_forand_index(ty_fournier_forand_slope(0.0183)),
                                                ty_fournier_forand_slope(0.0183)),
                 0.0183, 1e-9);
    /* One function on both sides of delta = 1, where its form is 0 / 0. */
    const double at_one = 2 * 0.75 * 0.1 * 0.1;
    assert_close(ty_fournier_forand(1.1, 3.5, at_one * 1.0011) / ty_fournier_forand(1.1, 3.5, at_one * 0.9989), 1,
                 0.01);
    assert_close(2 * ty_fournier_forand(1.1, 3.5, at_one) /
                     (ty_fournier_forand(1.1, 3.5, at_one * 1.002) + ty_fournier_forand(1.1, 3.5, at_one * 0.998)),
                 1, 1e-4);
}

/* ---- sampling ---- */

enum { BINS = 48 };

/* The tilt up to which bin i reaches: half of the bins in the logarithm, for peaks, and half in the cosine. */
static double bin_end(int i) {
    const int half = BINS / 2;
    if (i >= half) return 0.1 + 1.9 * (i + 1 - half) / half;
    return 1e-5 * pow(0.1 / 1e-5, (i + 1.0) / half);
}

static int bin_of(double tilt) {
    int i = 0;
    while (i + 1 < BINS && tilt > bin_end(i)) ++i;
    return i;
}

static void samples_follow_the_values(void** state) {
    enum { SAMPLES = 1 << 19 };
    const float weight[3] = {0.2f, 0.5f, 0.3f};
    for (int k = 0; k < PHASES; ++k) {
        ty_phase_view* view = view_of(*state, &phases[k]);
        const integrand m = {view, 0};
        int64_t counts[BINS] = {0};
        uint64_t random = 77 + (uint64_t)k;
        double sum = 0, chi = 0, square = moment_by_quadrature(view, 2) * 2 / 3 + 1.0 / 3;
        const double mean = moment_by_quadrature(view, 1);
        for (int i = 0; i < SAMPLES; ++i) {
            const float mu = ty_phase_sample_cosine(view, weight, (float)(uniform(&random) * (1 - 0x1p-24)));
            assert_true(mu >= -1 && mu <= 1);
            ++counts[bin_of(1 - (double)mu)];
            sum += (double)mu;
        }
        int used = 0;
        for (int i = 0; i < BINS; ++i) {
            const double low = i > 0 ? log(bin_end(i - 1)) : log(1e-13);
            const double expected = SAMPLES * ty_integrate(moment_at, &m, low, log(bin_end(i)), 200);
            if (expected < 20) continue;
            chi += pow((double)counts[i] - expected, 2) / expected;
            ++used;
        }
        const double off = (sum / SAMPLES - mean) * sqrt(SAMPLES / (square - mean * mean));
        const double deviations = (chi - (used - 1)) / sqrt(2.0 * (used - 1));
        printf("%-18s chi-square %+.2f over %d bins, mean cosine %+.2f (in standard deviations)\n", phases[k].name,
               deviations, used, off);
        assert_true(deviations < 4);
        assert_true(fabs(off) < 4);
        ty_phase_view_destroy(*state, view);
    }
}

/* Weights per channel: the mixture of channels that samples follow is that of the values. */
static void channels_have_their_own_weights(void** state) {
    const ty_phase_lobe lobes[2] = {{.weight = {1, 0, 3}, .g = 0.9}, {.weight = {0, 2, 1}, .g = -0.5}};
    ty_phase_view* view = NULL;
    assert_int_equal(ty_phase_view_create(*state, lobes, 2, &view), TY_OK);
    assert_int_equal(view->gray, 0);
    assert_close(view->moments[0][1], 0.9, 1e-6);
    assert_close(view->moments[1][1], -0.5, 1e-6);
    assert_close(view->moments[2][1], 0.75 * 0.9 - 0.25 * 0.5, 1e-6);
    const float weight[3] = {0.25f, 0.25f, 0.5f};
    uint64_t random = 5;
    double sum = 0;
    for (int i = 0; i < 1 << 16; ++i)
        sum += (double)ty_phase_sample_cosine(view, weight, (float)(0.999999 * uniform(&random)));
    assert_close(sum / (1 << 16), 0.25 * 0.9 - 0.25 * 0.5 + 0.5 * 0.55, 0.01);
    ty_phase_view_destroy(*state, view);
    double moments[6];
    assert_int_equal(ty_phase_moments(*state, lobes, 2, 1, moments), TY_OK);
    assert_close(moments[1], 0.9, 1e-6);
    assert_close(moments[5], 0.55, 1e-6);
}

/* ---- refusals ---- */

static void expect_refusal(ty_context* context, ty_phase_lobe lobe, const char* words) {
    float value[3];
    const double cosine = 0.5;
    assert_int_equal(ty_phase_values(context, &lobe, 1, 1, &cosine, value), TY_ERROR_ARGUMENT);
    assert_error(context, words);
}

static void bad_lobes_are_refused(void** state) {
    static const double back[] = {-1, 0.5, 0.2, 1}, short_of[] = {-1, 0, 0.9}, numbers[] = {1, 1, 1, 1},
                        negative[] = {1, -1, 1, 1}, zeros[] = {0, 0, 0, 0}, right[] = {-1, 0, 0.5, 1},
                        nans[] = {1, NAN, 1, 1};
    expect_refusal(*state, (ty_phase_lobe)DRAINE(1, 1, 0), "phase: g: 1 is outside (-1, 1)");
    expect_refusal(*state, (ty_phase_lobe)DRAINE(1, 0.5, -1), "phase: -1 is outside [0, 1e+06]");
    expect_refusal(*state, (ty_phase_lobe)DRAINE(-1, 0.5, 0), "phase: -1 is outside [0, 1e+15]");
    expect_refusal(*state, (ty_phase_lobe)DRAINE(0, 0.5, 0), "the weights add up to 0");
    expect_refusal(*state, (ty_phase_lobe)MIE(51), "51 is outside [0.001, 50]");
    expect_refusal(*state, (ty_phase_lobe)FORAND(.n = 1.1, .mu = 5), "5 is outside [3.01, 4.99]");
    expect_refusal(*state, (ty_phase_lobe)FORAND(.backscatter = 0.5), "0.5 is outside [0.0001, 0.2]");
    const ty_phase_lobe table = {
        .kind = TY_PHASE_TABLE, .weight = {1, 1, 1}, .cosines = right, .values = numbers, .count = 4};
    ty_phase_lobe bad = table;
    bad.cosines = back;
    expect_refusal(*state, bad, "node 2 is not beyond the one before");
    bad.cosines = short_of;
    bad.count = 3;
    expect_refusal(*state, bad, "do not reach from 0 to 180 degrees");
    bad = table;
    bad.values = negative;
    expect_refusal(*state, bad, "the value -1 of node 1");
    bad.values = nans;
    expect_refusal(*state, bad, "the value nan of node 1");
    bad.values = zeros;
    expect_refusal(*state, bad, "all values are 0");
    bad.count = 1;
    expect_refusal(*state, bad, "1 nodes are not 2..4096");
    bad = table;
    bad.kind = (ty_phase_kind)9;
    expect_refusal(*state, bad, "9 is not a ty_phase_kind");
    ty_medium_def both = ty_default_medium_def();
    both.g[1] = 0.5f;
    both.phase_count = 1;
    both.phase[0] = (ty_phase_lobe)MIE(10);
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(*state, TY_AXIS_Y, &scene), TY_OK);
    assert_int_equal(ty_scene_add_medium(scene, &both), TY_ERROR_ARGUMENT);
    assert_error(*state, "medium.phase gives the phase function already");
    both.g[1] = 0;
    both.phase_count = TY_PHASE_LOBES_MAX + 1;
    assert_int_equal(ty_scene_add_medium(scene, &both), TY_ERROR_ARGUMENT);
    assert_error(*state, "9 lobes are not 1..8");
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(functions_are_normalised),        cmocka_unit_test(moments_are_those_of_quadrature),
        cmocka_unit_test(values_are_the_formulas),         cmocka_unit_test(samples_follow_the_values),
        cmocka_unit_test(channels_have_their_own_weights), cmocka_unit_test(bad_lobes_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
