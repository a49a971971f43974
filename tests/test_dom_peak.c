/* Phase functions fitted outside of their peaks. */
#include "method/dom/solve/solve.h"
#include "scene/media/phase.k.h"
#include "checks.h"

#include <math.h>
#include <stdio.h>

static const double anisotropies[] = {0.77, 0.8, 0.9, 0.96, 0.98, 0.995};
enum { COUNT = sizeof anisotropies / sizeof anisotropies[0], BANDS = 10 };

/* The fraction of light that turns aside and its first moments are the phase function's, and all moments are those of a
 * function that can be. */
static void light_turns_as_much_as_it_should(void** state) {
    (void)state;
    for (int i = 0; i < COUNT; ++i)
        for (int32_t bands = TY_DOM_MIN_FITTED_BANDS; bands <= TY_DOM_BANDS_MAX; ++bands) {
            const double g = anisotropies[i];
            ty_forward_fit fit;
            ty_dom_fit_phase(g, bands, &fit);
            assert_int_equal(fit.bands, bands);
            assert_true(fit.forward_fraction > 0 && fit.forward_fraction < 1);
            assert_true(fabs((double)(fit.forward_fraction + fit.moments[0]) - 1) < 1e-6);
            for (int32_t l = 1; l < (bands < TY_DOM_BANDS_MAX ? 3 : 5); ++l)
                assert_true(fabs((double)(fit.moments[0] - fit.moments[l]) - (1 - pow(g, l))) < 1e-6);
            for (int32_t l = 1; l < bands; ++l)
                if (!(fabsf(fit.moments[l]) < fit.moments[0])) fail_msg("g %g, %d bands: c_%d", g, (int)bands, (int)l);
        }
}

/* The Legendre series of moments at mu, in double precision. */
static double legendre_series(const float* moments, int32_t bands, double mu) {
    double before = 0, now = 1, sum = 0;
    for (int l = 0; l < bands; ++l) {
        sum += (2 * l + 1) * (double)moments[l] * now;
        const double next = ((2 * l + 1) * mu * now - l * before) / (l + 1);
        before = now;
        now = next;
    }
    return sum / (4 * 3.14159265358979);
}

/* At 60 degrees and beyond fits are near the phase function: to these fractions of it as measured, with a margin of a
 * tenth. A series that is cut after as many bands is off by 1.1 to 16 times the phase function there (delta-M, Wiscombe
 * 1977). */
static void wide_angles_are_right(void** state) {
    static const double measured[COUNT] = {0.030, 0.038, 0.076, 0.111, 0.125, 0.136};
    (void)state;
    for (int i = 0; i < COUNT; ++i) {
        const double g = anisotropies[i];
        double fitted = 0;
        ty_forward_fit fit;
        ty_dom_fit_phase(g, BANDS, &fit);
        for (int degrees = 60; degrees <= 175; degrees += 5) {
            const float mu = (float)cos(degrees * 3.14159265358979 / 180), phase = ty_hg(mu, (float)g);
            const double series = legendre_series(fit.moments, BANDS, (double)mu);
            fitted = fmax(fitted, fabs(series / (double)phase - 1));
            assert_true(fabs((double)ty_forward_fitted(&fit, mu) - series) < 2e-3 * (double)phase);
        }
        printf("g %g: off by %.3f\n", g, fitted);
        if (!(fitted < 1.1 * measured[i] + 0.001)) fail_msg("g %g: off by %g", g, fitted);
    }
}

/* Of a line of light after n scatterings in the mean: what the fit lacks is the series of all moments less the fit's.
 */
static void the_peak_is_whole(void** state) {
    (void)state;
    for (int i = 0; i < COUNT; ++i) {
        const double g = anisotropies[i];
        ty_forward_fit fit;
        ty_dom_fit_phase(g, BANDS, &fit);
        for (double n = 0.1; n < 20; n *= 3)
            for (double mu = 0.91; mu < 1; mu += 0.03) {
                double before = 0, now = 1, sum = 0, all = 0;
                for (int l = 0; l < 8000; ++l) {
                    const double of_g = pow(g, l), straight = (double)fit.forward_fraction;
                    const double d = straight + (l < BANDS ? (double)fit.moments[l] : 0);
                    all += (2 * l + 1) * now * of_g * exp(n * (of_g - 1));
                    if (l < BANDS)
                        sum += (2 * l + 1) * now * (d * exp(n * (d - 1)) - straight * exp(n * (straight - 1)));
                    const double next = ((2 * l + 1) * mu * now - l * before) / (l + 1);
                    before = now;
                    now = next;
                }
                const ty_forward light = {(float)exp(-n), (float)exp(n * ((double)fit.forward_fraction - 1)), 0, 1};
                const double found =
                    4 * 3.14159265358979 * (double)ty_forward_fit_deficit(light, (float)mu, (float)g, &fit);
                if (!(fabs(found - (all - sum)) <= 0.04 * all))
                    fail_msg("g %g, n %g, mu %g: %g of %g is %g", g, n, mu, all - sum, all, found);
            }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(light_turns_as_much_as_it_should),
                                       cmocka_unit_test(wide_angles_are_right), cmocka_unit_test(the_peak_is_whole)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
