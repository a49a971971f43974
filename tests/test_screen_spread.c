/* The spread of points in screen-space scattering: by the variance of Eq. 2, or as the theory of small angles says,
 * which is drawn here event by event. */
#include "effort.h"
#include "screen_maker.h"

#include "method/screen/spread.h"

#include <stdio.h>

/* ---- Gaussians ---- */

/* The image of a white point at (x, y), distance 1 m, without what is not scattered, over what is. */
static picture point_image(ty_context* context, const ty_screen_def* def, int32_t side, int32_t x, int32_t y) {
    picture p = make_picture(side, side, 1);
    set_pixel(&p, x, y, 1, 1, 1);
    apply(context, def, &p);
    for (int c = 0; c < 3; ++c) {
        float* plane = p.out + c * pixel_count(&p);
        const double absorbed = exp(-(double)def->sigma_a[c]), kept = exp(-(double)def->sigma_s[c]);
        plane[y * side + x] -= (float)(absorbed * kept);
        for (int32_t i = 0; i < pixel_count(&p); ++i) plane[i] /= (float)(absorbed * (1 - kept));
    }
    return p;
}

/* Per axis, pixels^2, of the first channel about (x, y). */
static double variance_about(const picture* p, int32_t x, int32_t y) {
    double sum = 0;
    for (int32_t i = 0; i < pixel_count(p); ++i) {
        const double dx = i % p->width - x, dy = i / p->width - y;
        sum += 0.5 * (dx * dx + dy * dy) * (double)p->out[i];
    }
    return sum;
}

/* Means over 32 places of a point, since where it lies among the texels matters a little. */
static void check_variance(ty_context* context, variant v, int32_t filter, double sigma_s, double sigma_a, double g) {
    enum { SIDE = 200, PLACES = 32 }; /* the exact one does not care */
    const int places = v == REFERENCE ? 1 : PLACES;
    ty_screen_def def = gray_fog(sigma_s, sigma_a, g, 60);
    def.filter = filter;
    set_variant(&def, v);
    const double width = gaussian_spread(sigma_s, sigma_a, g, 1, 60), expected = width * width;
    double mean = 0, worst = 0;
    for (int i = 0; i < places; ++i) {
        const int32_t x = 84 + 5 * i % 32, y = 84 + 11 * i % 32;
        picture p = point_image(context, &def, SIDE, x, y);
        const double variance = variance_about(&p, x, y) / expected;
        mean += variance / places;
        worst = fmax(worst, fabs(variance - 1));
        assert_close(sum_of(p.out, pixel_count(&p)), 1, 1e-3);
        free_picture(&p);
    }
    printf("%s, filter %d, spread %.2f pixels: variance %.4f of Eq. 2's, at worst off by %.3f\n", variant_names[v],
           filter, width, mean, worst);
    assert_close(mean, 1, 0.002);
    assert_true(worst < (filter == 2 ? 0.35 : 0.02));
}

static void gaussians_have_the_variance_of_equation_2(void** state) {
    skip_under_sanitizers();
    for (int32_t filter = 2; filter <= 6; filter += 2) {
        check_variance(*state, GAUSSIAN, filter, 0.02, 0, 0.9);
        check_variance(*state, GAUSSIAN, filter, 0.3, 0, 0.9);
        check_variance(*state, GAUSSIAN, filter, 0.5, 1, 0.5);
        check_variance(*state, GAUSSIAN, filter, 1, 0.2, 0.7);
        check_variance(*state, GAUSSIAN, filter, 3, 4, 0.8);
    }
    check_variance(*state, REFERENCE, 4, 0.3, 0, 0.9);
    check_variance(*state, REFERENCE, 4, 0.5, 1, 0.5);
}

/* All variants spread light about where it came from. The paper's third level is as wide as three filters, of 1.25
 * texels^2 each, and the cubic lookup's 1/3 texel^2 make it; Eq. 10 takes it for 41 pixels^2. */
static void points_stay_in_place(void** state) {
    enum { SIDE = 200, X = 97, Y = 106 };
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        if (v == REFERENCE) continue;                    /* exact */
        ty_screen_def def = gray_fog(1, 0, 0.9, 57.243); /* spread over 6.4 pixels: level 3 */
        def.filter = 6;
        set_variant(&def, (variant)v);
        picture p = point_image(*state, &def, SIDE, X, Y);
        double sum = 0, x = 0, y = 0;
        for (int32_t i = 0; i < pixel_count(&p); ++i) {
            sum += (double)p.out[i];
            x += (i % SIDE - X) * (double)p.out[i];
            y += (i / SIDE - Y) * (double)p.out[i];
        }
        printf("%s: %.4f %.4f pixels off\n", variant_names[v], x / sum, y / sum);
        assert_close(x / sum, 0, v == SMALL_ANGLE ? 0.5 : 0.02); /* its tails meet the edges */
        assert_close(y / sum, 0, v == SMALL_ANGLE ? 0.5 : 0.02);
        if (v == GATHER || v == NAIVE || v == PUBLISHED)
            assert_close(variance_about(&p, X, Y) / sum, 1.25 * (1 + 4 + 16) + 64 / 3.0, 0.2);
        free_picture(&p);
    }
}

/* ---- small angles ---- */

enum { DRAWS = 100000 };

/* Scattering events drawn at random: Poisson's number of them, at least one, each at its own fraction of the way. Each
 * spreads light by a planar Cauchy kernel, whose widths add up to that sum of fractions. */
static double draw_way(double thickness, uint64_t* random) {
    const double u = exp(-thickness) + uniform(random) * -expm1(-thickness);
    double term = exp(-thickness), below = term, way = 0;
    for (int n = 1; n < 400 && below <= u; ++n) {
        term *= thickness / n;
        below += term;
        way += uniform(random);
    }
    return way;
}

/* A planar Cauchy kernel's part that is wider than a Gaussian of some variance is an error function. */
static void tails_are_those_of_the_theory(void** state) {
    (void)state;
    static const double thicknesses[] = {0.01, 0.5, 1, 2, 4, 7.9, 8.1, 12, 15.9, 16.1, 40};
    for (int i = 0; i < 11; ++i)
        for (double variance = 0.01; variance < 1e4; variance *= 5) {
            uint64_t random = 98;
            double sum = 0;
            for (int k = 0; k < DRAWS / 5; ++k) sum += erf(draw_way(thicknesses[i], &random) / sqrt(2 * variance));
            assert_close(ty_screen_wider_fraction(1, thicknesses[i], variance), sum / (DRAWS / 5), 0.01);
        }
}

/* The light that reaches a level, by its polynomials, is the mean of the tail over the level's own range: evenly in the
 * logarithm of the variance, above the first level. */
static void shares_follow_tails(void** state) {
    enum { LEVELS = 12 };
    (void)state;
    float levels[LEVELS + 1] = {0};
    for (int k = 0; k < LEVELS; ++k)
        levels[k + 1] = levels[k] + ty_screen_taps_variance(ty_screen_choose_taps(4)) * exp2f(2 * (float)k);
    for (double width = 0.3; width < 300; width *= 3)
        for (double thickness = 0.01; thickness < 50; thickness *= 1.7) {
            ty_screen_down_fraction shares[LEVELS];
            double reached = 1;
            ty_screen_small_angle_fractions(width, levels, LEVELS, shares);
            for (int k = 0; k < LEVELS; ++k) {
                double mean = 0;
                for (int i = 0; i < 100; ++i) {
                    const double t = (i + 0.5) / 100, low = (double)levels[k], high = (double)levels[k + 1];
                    const double variance = k == 0 ? t * high : low * pow(high / low, t);
                    mean += ty_screen_wider_fraction(width, thickness, variance) / 100;
                }
                reached *= (double)ty_screen_down_fraction_at(shares[k], (float)thickness);
                assert_close(reached, mean, 0.03);
            }
        }
}

/* Within a radius, pixels, of the first channel about the middle of pixel (x, y). */
static double energy_within(const picture* p, int32_t x, int32_t y, double radius) {
    double sum = 0;
    for (int32_t i = 0; i < pixel_count(p); ++i) {
        const double away = hypot(i % p->width - x, i / p->width - y);
        sum += fmin(fmax(radius - away + 0.5, 0), 1) * (double)p->out[i];
    }
    return sum;
}

/* The same by theory. radius in units of (1 - g) / sqrt(g) radians. */
static double drawn_energy(double thickness, double radius) {
    uint64_t random = 99;
    double sum = 0;
    for (int i = 0; i < DRAWS; ++i) {
        const double way = draw_way(thickness, &random);
        sum += 1 - way / hypot(way, radius);
    }
    return sum / DRAWS;
}

static void check_small_angles(ty_context* context, int32_t filter, double g, double thickness) {
    enum { SIDE = 420, AT = 211 };
    static const double radii[] = {4, 8, 16, 32, 64, 100};
    ty_screen_def def = gray_fog(thickness, 0, g, 200);
    def.filter = filter;
    def.levels = TY_SCREEN_LEVELS_MAX;
    picture p = point_image(context, &def, SIDE, AT, AT - 4);
    const double width = 200 * (1 - g) / sqrt(g);
    for (int i = 0; i < 6; ++i) {
        const double theory = drawn_energy(thickness, radii[i] / width);
        const double energy = energy_within(&p, AT, AT - 4, radii[i]);
        printf("g %g, thickness %g, filter %d, %3g pixels: %.3f, theory %.3f\n", g, thickness, filter, radii[i], energy,
               theory);
        assert_close(energy, theory, 0.02);
    }
    free_picture(&p);
}

static void small_angles_are_those_of_the_theory(void** state) {
    check_small_angles(*state, 4, 0.97, 0.05);
    check_small_angles(*state, 4, 0.97, 1);
    check_small_angles(*state, 4, 0.97, 3);
    check_small_angles(*state, 4, 0.97, 9);
    check_small_angles(*state, 2, 0.9, 0.5);
    check_small_angles(*state, 6, 0.9, 2);
    check_small_angles(*state, 4, 0.99, 6);
}

/* The radius that is said to hold half of the light does. */
static void half_of_the_light_is_within_the_spread(void** state) {
    static const double thicknesses[] = {0.01, 0.5, 1, 2, 4, 8, 20};
    for (int i = 0; i < 7; ++i) {
        picture p = make_picture(2, 2, 1);
        const ty_screen_image image = image_of(&p);
        const ty_screen_def def = gray_fog(thicknesses[i], 0, 0.95, 500);
        float spread[4];
        float *const none[3] = {NULL, NULL, NULL}, *const red[3] = {spread, NULL, NULL};
        assert_int_equal(ty_screen_split(*state, &def, &image, none, none, red), TY_OK);
        const double within = drawn_energy(thicknesses[i], (double)spread[0] / (500 * 0.05 / sqrt(0.95)));
        printf("thickness %g: %.3f of the light within the spread\n", thicknesses[i], within);
        assert_close(within, 0.5, 0.01);
        free_picture(&p);
    }
}

/* Each channel of a coloured medium as if it were alone. */
static void channels_do_not_mix(void** state) {
    static const variant variants[] = {SMALL_ANGLE, GAUSSIAN, REFERENCE};
    for (int i = 0; i < 3; ++i) {
        picture p = make_picture(70, 45, 1), alone = make_picture(70, 45, 1);
        fill_random(&p, 0.5, 40, 8);
        fill_random(&alone, 0.5, 40, 8);
        ty_screen_def def = gray_fog(0, 0, 0, 50);
        set3f(def.sigma_s, 0.3, 0.02, 0);
        set3f(def.sigma_a, 0.01, 0, 0.05);
        set3f(def.g, 0.9, 0.2, 0.5);
        def.levels = 5;
        set_variant(&def, variants[i]);
        apply(*state, &def, &p);
        for (int c = 0; c < 3; ++c) {
            ty_screen_def one = gray_fog((double)def.sigma_s[c], (double)def.sigma_a[c], (double)def.g[c], 50);
            one.levels = 5;
            set_variant(&one, variants[i]);
            apply(*state, &one, &alone);
            for (int32_t k = c * pixel_count(&p); k < (c + 1) * pixel_count(&p); ++k)
                assert_close((double)p.out[k], (double)alone.out[k], 1e-6 * (double)alone.out[k]);
        }
        free_picture(&p);
        free_picture(&alone);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gaussians_have_the_variance_of_equation_2),
        cmocka_unit_test(points_stay_in_place),
        cmocka_unit_test(tails_are_those_of_the_theory),
        cmocka_unit_test(shares_follow_tails),
        cmocka_unit_test(small_angles_are_those_of_the_theory),
        cmocka_unit_test(half_of_the_light_is_within_the_spread),
        cmocka_unit_test(channels_do_not_mix),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
