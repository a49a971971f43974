/* Rough and smooth dielectric interfaces: what a white furnace holds, both ways of the light, densities that belong to
 * their samples. */
#include "base/random.k.h"
#include "checks.h"
#include "effort.h"
#include "scene/bsdf/dielectric.k.h"
#include "scene/bsdf/tables.h"

enum { SIDE = 96 };

static const float white[3] = {1, 1, 1};
static const float etas[] = {1.05f, 1.33f, 1.5f, 2.4f, 1 / 1.05f, 1 / 1.33f, 1 / 1.5f, 1 / 2.4f};
static const float roughnesses[] = {0.05f, 0.1f, 0.2f, 0.35f, 0.5f, 0.7f, 0.85f, 1};
static const float cosines[] = {0.02f, 0.05f, 0.1f, 0.2f, 0.4f, 0.6f, 0.8f, 0.95f, 1};

#define COUNT(list) (sizeof(list) / sizeof *(list))

static ty_rough_dielectric prepare(float eta, float roughness, ty_vec wo, bool compensated) {
    const ty_frame frame = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    ty_rough_dielectric d;
    ty_rough_dielectric_prepare(&d, &ty_bsdf_default_tables, &frame, wo, eta, roughness, white, compensated);
    return d;
}

static ty_vec at_cosine(float cosine) {
    return ty_vec_make(sqrtf(1 - cosine * cosine), 0, cosine);
}

/* The light that a direction brings in a furnace of equal L / n^2 on both sides, if its lobe has a probability. */
static double bring(const ty_rough_dielectric* d, float pick, float u, float v, double probability) {
    ty_vec wi;
    float factor[3];
    if (!(probability > 0) || !ty_rough_dielectric_sample(d, pick, u, v, &wi)) return 0;
    const float pdf = ty_rough_dielectric_evaluate(d, wi, factor);
    return pdf > 0 ? probability * (double)(factor[0] / pdf) : 0;
}

/* The light that a furnace sends along wo, by the interface's own samples: a grid of them for each lobe. */
static double furnace(const ty_rough_dielectric* d) {
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const float u = ((float)(i / SIDE) + 0.5f) / SIDE, v = ((float)(i % SIDE) + 0.5f) / SIDE;
        const ty_vec h = ty_ggx_sample_visible(d->wo, d->alpha, u, v);
        const float once = 1 - d->lost, reflected = once * ty_fresnel_dielectric(ty_dot(d->wo, h), d->eta);
        const float crosses = d->lost * d->through;
        /* Cosines of what smooth surfaces lose are small: they are sampled more finely. */
        const float fine = ((float)i + 0.5f) / (SIDE * SIDE), turn = (float)fmod(i * 0.6180339887498949, 1);
        sum += bring(d, 0.5f * crosses, fine, turn, (double)crosses);
        sum += bring(d, 0.5f * (crosses + d->lost), fine, turn, (double)(d->lost - crosses));
        sum += bring(d, d->lost + 0.5f * reflected, u, v, (double)reflected);
        sum += bring(d, d->lost + 0.5f * (reflected + once), u, v, (double)(once - reflected));
    }
    return sum / (SIDE * SIDE);
}

static void white_furnaces_stay_white(void** state) {
    (void)state;
    double worst = 0;
    for (size_t e = 0; e < COUNT(etas); ++e)
        for (size_t r = 0; r < COUNT(roughnesses); ++r)
            for (size_t i = 0; i < COUNT(cosines); i += in_full() ? 1 : 2) {
                const ty_rough_dielectric d = prepare(etas[e], roughnesses[r], at_cosine(cosines[i]), true);
                const double out = furnace(&d);
                worst = fmax(worst, fabs(out - 1));
                if (!(fabs(out - 1) < 0.005))
                    fail_msg("eta %g, roughness %g, cosine %g: %g of the light", (double)etas[e],
                             (double)roughnesses[r], (double)cosines[i], out);
            }
    print_message("white furnace: within %.4f\n", worst);
}

/* Single scattering with separable masking of alpha .09, ior 1.5, at n.v .98 .8 .5 .2 (shared references of materials).
 */
static void uncompensated_interfaces_lose_light(void** state) {
    (void)state;
    static const float views[] = {0.98f, 0.8f, 0.5f, 0.2f};
    static const double outside[] = {0.999, 0.998, 0.994, 0.956}, inside[] = {0.991, 0.983, 0.970, 0.903};
    for (int i = 0; i < 4; ++i) {
        const ty_rough_dielectric from_outside = prepare(1.5f, 0.3f, at_cosine(views[i]), false);
        const ty_rough_dielectric from_inside = prepare(1 / 1.5f, 0.3f, at_cosine(views[i]), false);
        /* Reflection has correlated masking here, which keeps more. */
        assert_close(furnace(&from_outside), outside[i], 0.01);
        assert_close(furnace(&from_inside), inside[i], 0.03);
    }
}

/* n_o^2 cos_o K(wo, wi) = n_i^2 cos_i K(wi, wo), with K the BSDF for L / n^2 times cosine. */
static void light_takes_both_ways_alike(void** state) {
    (void)state;
    ty_sampler random = {.key = 1};
    for (size_t e = 0; e < COUNT(etas); ++e)
        for (int i = 0; i < 400; ++i) {
            const ty_vec up = {0, 0, 1};
            const ty_vec wo = ty_direction_about(up, 0.05f + 0.95f * ty_rng_uniform(&random), ty_rng_uniform(&random));
            ty_vec wi = ty_direction_about(up, 0.05f + 0.95f * ty_rng_uniform(&random), ty_rng_uniform(&random));
            const bool through = i % 2 == 1;
            if (through) wi.z = -wi.z;
            const ty_rough_dielectric there = prepare(etas[e], 0.6f, wo, i % 4 < 2);
            /* Seen from the other side the interface is upside down. */
            ty_vec from = wi, to = wo;
            if (through) from.z = -from.z, to.z = -to.z;
            const ty_rough_dielectric back = prepare(through ? 1 / etas[e] : etas[e], 0.6f, from, i % 4 < 2);
            float forth[3], reverse[3];
            ty_rough_dielectric_evaluate(&there, wi, forth);
            ty_rough_dielectric_evaluate(&back, to, reverse);
            const double square = through ? (double)(etas[e] * etas[e]) : 1;
            const double a = (double)(forth[0] * wo.z), b = square * (double)(reverse[0] * fabsf(wi.z));
            assert_close(a, b, 3e-3 * fmax(a, b) + 1e-5);
        }
}

/* ---- densities ---- */

/* Rings of equal height in the whole sphere. */
enum { RINGS = 24, TURNS = 8, BINS = RINGS * TURNS, DRAWS = 200000 };

static ty_vec in_sphere(double z, double turn) {
    return ty_direction_about(ty_vec_make(0, 0, 1), (float)z, (float)turn);
}

static double pdf_over(const ty_rough_dielectric* d, double from, double to, double turn, double turn_to, int steps) {
    double sum = 0;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            float factor[3];
            const ty_vec wi =
                in_sphere(from + (to - from) * (i + 0.5) / steps, turn + (turn_to - turn) * (j + 0.5) / steps);
            sum += (double)ty_rough_dielectric_evaluate(d, wi, factor);
        }
    return sum * (to - from) * (turn_to - turn) * 6.283185307179586 / (steps * steps);
}

static void samples_have_their_densities(void** state) {
    (void)state;
    static const float picked[] = {1.5f, 1 / 1.5f, 1.33f, 1 / 2.4f};
    ty_sampler random = {.key = 7};
    for (size_t e = 0; e < COUNT(picked); ++e)
        for (int i = 0; i < 4; ++i) {
            const ty_rough_dielectric d =
                prepare(picked[e], i % 2 == 0 ? 0.5f : 0.9f, at_cosine(i < 2 ? 0.9f : 0.4f), true);
            double counts[BINS] = {0}, statistic = 0, kept = 0, whole = 0;
            int freedom = 0;
            for (int n = 0; n < DRAWS; ++n) {
                const float pick = ty_rng_uniform(&random), u = ty_rng_uniform(&random), v = ty_rng_uniform(&random);
                ty_vec wi;
                if (!ty_rough_dielectric_sample(&d, pick, u, v, &wi)) continue;
                double turn = atan2((double)wi.y, (double)wi.x) / 6.283185307179586;
                if (turn < 0) turn += 1;
                const int ring = (int)((0.5 * (double)wi.z + 0.5) * RINGS), sector = (int)(turn * TURNS);
                counts[(ring < RINGS ? ring : RINGS - 1) * TURNS + (sector < TURNS ? sector : TURNS - 1)] += 1;
                ++kept;
            }
            /* Azimuths of wi begin at s, which is x for an axis along z. */
            for (int bin = 0; bin < BINS; ++bin) {
                const double ring = bin / TURNS, sector = bin % TURNS;
                const double mass = pdf_over(&d, 2 * ring / RINGS - 1, 2 * (ring + 1) / RINGS - 1, sector / TURNS,
                                             (sector + 1) / TURNS, 48);
                const double expected = DRAWS * mass;
                whole += mass;
                if (expected < 20) continue;
                statistic += (counts[bin] - expected) * (counts[bin] - expected) / expected;
                ++freedom;
            }
            assert_close(whole, kept / DRAWS, 0.005);
            if (!(statistic < freedom + 5 * sqrt(2.0 * freedom)))
                fail_msg("eta %g, case %d: chi-square %g of %d", (double)picked[e], i, statistic, freedom);
        }
}

/* ---- smooth interfaces ---- */

/* Reflectance of glass at normal incidence, at Brewster's angle (half of the reflectance for light that is polarised
 * across the plane of incidence) and beyond the critical angle; Snell's law. */
static void smooth_interfaces_follow_fresnel(void** state) {
    (void)state;
    const double eta = 1.5, brewster = cos(atan(eta));
    const double perpendicular = pow((1 - eta * eta) / (1 + eta * eta), 2);
    assert_close((double)ty_fresnel_dielectric(1, 1.5f), 0.04, 1e-6);
    assert_close((double)ty_fresnel_dielectric((float)brewster, 1.5f), 0.5 * perpendicular, 1e-6);
    assert_close((double)ty_fresnel_dielectric(0, 1.5f), 1, 1e-6);
    assert_true(ty_fresnel_dielectric(0.74f, 1 / 1.5f) == 1);
    assert_true(ty_fresnel_dielectric(0.75f, 1 / 1.5f) < 1);
    for (int i = 1; i <= 20; ++i) {
        const float cosine = (float)i / 20;
        const ty_vec wi = ty_refract(at_cosine(cosine), ty_vec_make(0, 0, 1), 1.5f);
        const double sine = sqrt(1 - (double)(cosine * cosine));
        assert_close(-(double)wi.x, sine / 1.5, 1e-5);
        assert_true(wi.z < 0);
        /* Both ways reflect alike. */
        assert_close((double)ty_fresnel_dielectric(-wi.z, 1 / 1.5f), (double)ty_fresnel_dielectric(cosine, 1.5f), 1e-4);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_furnaces_stay_white),        cmocka_unit_test(uncompensated_interfaces_lose_light),
        cmocka_unit_test(light_takes_both_ways_alike),      cmocka_unit_test(samples_have_their_densities),
        cmocka_unit_test(smooth_interfaces_follow_fresnel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
