/* Screen-space scattering between pixels: uniform stays uniform, light is kept, the reference is the sum it
 * claims to be, and near light does not leak. */
#include "effort.h"
#include "screen_maker.h"

#include "method/screen/kernel.h"

#include <stdio.h>

/* ---- uniform pictures and energy ---- */

static void check_uniform(ty_context* context, variant v, int32_t filter, int32_t levels, double distance) {
    picture p = make_picture(37, 22, distance);
    fill_color(&p, 3, 0.25, 40);
    ty_screen_def def = gray_fog(0.05, 0.01, 0.6, 80);
    def.filter = filter;
    def.levels = levels;
    def.window = 12;
    set_variant(&def, v);
    apply(context, &def, &p);
    for (int32_t i = 0; i < 3 * pixel_count(&p); ++i) {
        const double expected = (double)p.color[i] * exp(-0.01 * distance);
        if (!(fabs((double)p.out[i] - expected) <= 1e-5 * expected))
            fail_msg("%s, filter %d, levels %d, %g m: %g is not %g", variant_names[v], filter, levels, distance,
                     (double)p.out[i], expected);
    }
    free_picture(&p);
}

/* Also where the paper's masks have just begun to open: spreads a little above 0.8, 1.6 and 3.2 pixels. */
static void uniform_stays_uniform(void** state) {
    static const int32_t levels[] = {1, 2, 3, 4, 6, 9, 15, TY_AUTO, TY_SCREEN_LEVELS_ALL};
    static const double distances[] = {0.001, 0.04001, 0.16008, 0.3, 0.65, 7, 90};
    for (int v = 0; v < VARIANT_COUNT; ++v)
        for (int32_t filter = 2; v != PUBLISHED && filter <= 6; filter += 2)
            for (int i = 0; i < 9; ++i)
                for (int j = 0; j < 7; ++j) check_uniform(*state, (variant)v, filter, levels[i], distances[j]);
}

/* Energy of a scattered highlight in the middle over the energy that absorption leaves. */
static double kept_energy(ty_context* context, variant v, int32_t filter, double distance) {
    picture p = make_picture(128, 128, distance);
    for (int32_t y = 62; y < 67; ++y)
        for (int32_t x = 61; x < 68; ++x) set_pixel(&p, x, y, 5000, 700, 90);
    ty_screen_def def = gray_fog(0.2, 0.03, 0.99, 300);
    def.filter = filter;
    set_variant(&def, v);
    apply(context, &def, &p);
    const double kept = sum_of(p.out, 3 * pixel_count(&p)) / (sum_of(p.color, 3 * pixel_count(&p)));
    free_picture(&p);
    return kept / exp(-0.03 * distance);
}

/* The masks as published take some of it away; all others keep it. */
static void highlights_keep_their_energy(void** state) {
    skip_under_sanitizers();
    static const double distances[] = {0.1, 1, 4, 10}; /* at most a tenth of the picture wide */
    for (int v = 0; v < VARIANT_COUNT; ++v)
        for (int32_t filter = 2; filter <= (v == REFERENCE ? 2 : 6); filter += 2) { /* it has none */
            double least = 1;
            for (int i = 0; i < (v == REFERENCE ? 3 : 4); ++i) {
                const double kept = kept_energy(*state, (variant)v, filter, distances[i]);
                least = fmin(least, kept);
                if (v != PUBLISHED) assert_close(kept, 1, 0.01);
            }
            printf("energy kept by %s, filter %d: %.4f at least\n", variant_names[v], filter, least);
            if (v == PUBLISHED) assert_true(least < 0.9);
        }
}

/* Light of all distances in one picture: none is lost where it is spread from its own pixel. Tails of small angles meet
 * the picture's edges, where odd sides of levels cost a little. */
static void no_light_is_lost_at_edges_of_depth(void** state) {
    skip_under_sanitizers();
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        picture p = make_picture(151, 132, 15);
        uint64_t random = 7;
        double whole = 0;
        for (int32_t y = 60; y < 72; ++y)
            for (int32_t x = 64; x < 86; ++x) {
                const double color = pow(10, uniform_in(&random, -1, 3)), d = uniform(&random) < 0.5 ? 1.5 : 9;
                set_pixel(&p, x, y, color, color, color);
                p.distance[y * 151 + x] = (float)d;
                whole += 3 * color * exp(-0.03 * d);
            }
        ty_screen_def def = gray_fog(0.2, 0.03, 0.99, 300);
        set_variant(&def, (variant)v);
        apply(*state, &def, &p);
        const double kept = sum_of(p.out, 3 * pixel_count(&p)) / whole;
        printf("energy kept at edges of depth by %s: %.4f\n", variant_names[v], kept);
        if (v == SMALL_ANGLE) assert_close(kept, 1, 0.03);
        if (v == GAUSSIAN || v == REFERENCE) assert_close(kept, 1, 0.01);
        free_picture(&p);
    }
}

/* ---- the reference ---- */

/* The sum of a Gaussian over the pixels -before..after, or as far as it can be told from 0. */
static double lattice_sum(double variance, int before, int after) {
    const double reach = 9 * sqrt(variance) + 1;
    double sum = 0;
    for (int i = -(int)fmin(before, reach); i <= (int)fmin(after, reach); ++i) sum += exp(-0.5 * i * i / variance);
    return sum;
}

/* The first channel of the reference at (x, y), in double precision: all sources, each normalised over
 * its window of the endless lattice, over what of the pixel's own light would stay in the picture. */
static double exact_scattered(const picture* p, const ty_screen_def* def, int32_t x, int32_t y) {
    const double s = (double)def->sigma_s[0], a = (double)def->sigma_a[0], g = (double)def->g[0];
    const int before = def->window > 0 ? def->window / 2 : INT32_MAX,
              after = def->window > 0 ? (def->window - 1) / 2 : INT32_MAX;
    double sum = 0, covered = 0;
    const double own = gaussian_spread(s, a, g, (double)p->distance[y * p->width + x], def->focal[0]);
    const double own_sum = lattice_sum(own * own, before, after);
    for (int32_t i = 0; i < pixel_count(p); ++i) {
        const int dx = x - i % p->width, dy = y - i / p->width;
        if (dx < -before || dx > after || dy < -before || dy > after) continue;
        const double d = (double)p->distance[i], width = gaussian_spread(s, a, g, d, def->focal[0]);
        const double whole = lattice_sum(width * width, before, after);
        const double square = dx * dx + dy * dy;
        sum +=
            (double)p->color[i] * exp(-a * d) * -expm1(-s * d) * exp(-0.5 * square / (width * width)) / (whole * whole);
        covered += exp(-0.5 * square / (own * own)) / (own_sum * own_sum);
    }
    return sum / covered;
}

static void reference_is_the_sum_over_all_pixels(void** state) {
    static const int32_t windows[] = {0, 1, 2, 5, 8, 100};
    for (int i = 0; i < 6; ++i) {
        picture p = make_picture(71, 9, 1);
        fill_random(&p, 0.1, 200, 9);
        ty_screen_def def = gray_fog(0.05, 0.01, 0.8, 60);
        def.window = windows[i];
        set_variant(&def, REFERENCE);
        apply(*state, &def, &p);
        for (int32_t k = 0; k < pixel_count(&p); k += 19) {
            const double kept = exp(-0.06 * (double)p.distance[k]) * (double)p.color[k];
            const double expected = kept + exact_scattered(&p, &def, k % 71, k / 71);
            assert_close((double)p.out[k], expected, 3e-5 * expected);
        }
        free_picture(&p);
    }
}

/* ---- depth ---- */

/* Poles and a ball with a highlight before a wall, all with texture. */
static picture room(void) {
    picture p = make_picture(120, 80, 60);
    uint64_t random = 10;
    for (int32_t i = 0; i < pixel_count(&p); ++i) {
        const int32_t x = i % 120, y = i / 120;
        double color = 0.4 + 0.3 * ((x / 9 + y / 9) % 2), d = 60;
        if (x % 31 < 4) {
            color = 0.1;
            d = 8 + 0.1 * x;
        }
        const double ball = hypot(x - 70, y - 40);
        if (ball < 17) {
            color = ball < 4 ? 60 : 0.8;
            d = 3 + 0.02 * ball * ball;
        }
        color *= uniform_in(&random, 0.8, 1.2);
        set_pixel(&p, x, y, color, 0.7 * color, 0.4 * color);
        p.distance[i] = (float)d;
    }
    return p;
}

static double relative_error(const float* values, const float* truth, int32_t count) {
    const double mean = sum_of(truth, count) / count;
    double sum = 0;
    for (int32_t i = 0; i < count; ++i) {
        const double off = (double)values[i] - (double)truth[i];
        sum += off * off / ((double)truth[i] * (double)truth[i] + 0.01 * mean * mean);
    }
    return sum / count;
}

/* Against the exact sum with the same Gaussians. */
static void scatter_is_near_the_reference(void** state) {
    picture truth = room(), p = room();
    double errors[VARIANT_COUNT] = {0};
    for (int v = VARIANT_COUNT - 1; v >= GAUSSIAN; --v) {
        ty_screen_def def = gray_fog(0.03, 0.005, 0.8, 100);
        set_variant(&def, (variant)v);
        apply(*state, &def, v == REFERENCE ? &truth : &p);
        errors[v] = relative_error(p.out, truth.out, 3 * pixel_count(&p));
        if (v != REFERENCE) printf("%s: relMSE %.2e against the reference\n", variant_names[v], errors[v]);
    }
    assert_true(errors[GAUSSIAN] < 8e-3);
    assert_true(errors[GAUSSIAN] < 0.65 * errors[GATHER]);
    assert_true(errors[GAUSSIAN] < 0.65 * errors[NAIVE]);
    free_picture(&p);
    free_picture(&truth);
}

/* A bright bar 1 m away before a black wall at 60 m: what of its scattered light the wall shows farther from it than
 * six of its own standard deviations. */
static double leaked(ty_context* context, variant v) {
    const ty_screen_def fog = gray_fog(0.05, 0, 0.8, 60);
    const int32_t bar = 40, beyond = 8 + (int32_t)(6 * gaussian_spread(0.05, 0, 0.8, 1, 60));
    picture p = make_picture(160, 64, 60);
    for (int32_t y = 0; y < 64; ++y)
        for (int32_t x = bar; x < bar + 8; ++x) {
            set_pixel(&p, x, y, 100, 100, 100);
            p.distance[y * 160 + x] = 1;
        }
    ty_screen_def def = fog;
    set_variant(&def, v);
    apply(context, &def, &p);
    double sum = 0;
    for (int32_t i = 0; i < pixel_count(&p); ++i)
        if (abs(i % 160 - bar - 4) > beyond) sum += (double)p.out[i];
    free_picture(&p);
    return sum / (64 * 8 * 100 * -expm1(-0.05));
}

static void near_light_does_not_leak(void** state) {
    double leak[VARIANT_COUNT];
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        leak[v] = leaked(*state, (variant)v);
        printf("%s: %.5f of the scattered light leaks\n", variant_names[v], leak[v]);
    }
    assert_true(leak[REFERENCE] < 1e-6);
    assert_true(leak[GAUSSIAN] < 0.003);
    assert_true(leak[NAIVE] > 0.15);
    assert_true(leak[GATHER] < 0.5 * leak[NAIVE]);
}

/* ---- the paper's parts ---- */

static void masks_and_levels_are_the_papers(void** state) {
    (void)state;
    const ty_screen_mask_params smooth = {TY_SCREEN_MASK_SMOOTH, 3.2f, 0.5f}, step = {TY_SCREEN_MASK_STEP, 3.2f, 0.5f};
    for (int i = 0; i <= 80; ++i) {
        const double spread = 0.08 * i, t = fmin(fmax((spread - 3.2) / (0.5 * 3.2), 0), 1);
        assert_close((double)ty_screen_mask_at(smooth, (float)spread), t * t * (3 - 2 * t), 1e-6);
        if (i != 40) assert_close((double)ty_screen_mask_at(step, (float)spread), spread >= 3.2, 0);
    }
    for (int i = 0; i < 70; ++i) {
        const double spread = 0.1 * pow(1.2, i), level = fmin(fmax(log2(spread / 0.8), 0), 6);
        assert_close((double)ty_screen_level_at((float)(spread * spread), 0.8f, 6), level, 1e-5);
    }
}

/* Eq. 8: a level's spread is the mean of the finer one's, weighted by luminance or not. */
static void spread_is_weighted_by_luminance(void** state) {
    (void)state;
    const float texels[16] = {10, 20, 5, 1, 1, 0, 0, 1, 0, 0, 0, 1, 3, 3, 3, 1}, spread[4] = {4, 9, 100, 2};
    const double luminance[4] = {0.2126 * 10 + 0.7152 * 20 + 0.0722 * 5, 0.2126, 0, 3};
    for (int weighted = 0; weighted < 2; ++weighted) {
        const ty_screen_gather_params params = {
            .mask = {TY_SCREEN_MASK_SMOOTH, 1, 0.5f}, .luminance_weights = weighted, .normalise = 1};
        float rows[TY_GATHER_ROWS][4], filtered[TY_GATHER_ROWS][2], coarse[8], coarse_spread[2], narrowed[2];
        float* into[TY_GATHER_ROWS];
        const float* from[TY_GATHER_ROWS];
        for (int kind = 0; kind < TY_GATHER_ROWS; ++kind) into[kind] = rows[kind];
        ty_screen_kernels_v1.gather_rows(&params, texels, spread, 4, into);
        ty_screen_taps box = ty_screen_choose_taps(2);
        for (int kind = 0; kind < TY_GATHER_ROWS; ++kind) {
            const float weights[6] = {0, 0, 0.5f, 0.5f, 0, 0};
            const float* const both[6] = {narrowed, narrowed, narrowed, narrowed, narrowed, narrowed};
            ty_screen_kernels_v1.downsample(&box, rows[kind], 4, NULL, narrowed);
            ty_screen_kernels_v1.combine_rows(weights, both, 2, filtered[kind]);
            from[kind] = filtered[kind];
        }
        ty_screen_kernels_v1.gather_store(&params, from, 2, coarse, coarse_spread);
        for (int i = 0; i < 2; ++i) {
            const double a = weighted ? luminance[2 * i] : 1, b = weighted ? luminance[2 * i + 1] : 1;
            const double expected = (a * (double)spread[2 * i] + b * (double)spread[2 * i + 1]) / (a + b);
            assert_close((double)coarse_spread[i], expected, 1e-5 * expected);
            assert_close((double)coarse[4 * i], 0.5 * ((double)texels[8 * i] + (double)texels[8 * i + 4]), 1e-5);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uniform_stays_uniform),
        cmocka_unit_test(highlights_keep_their_energy),
        cmocka_unit_test(no_light_is_lost_at_edges_of_depth),
        cmocka_unit_test(reference_is_the_sum_over_all_pixels),
        cmocka_unit_test(scatter_is_near_the_reference),
        cmocka_unit_test(near_light_does_not_leak),
        cmocka_unit_test(masks_and_levels_are_the_papers),
        cmocka_unit_test(spread_is_weighted_by_luminance),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
