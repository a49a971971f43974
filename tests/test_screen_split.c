/* Screen-space scattering, pixel by pixel: what is attenuated and scattered, what the environment adds, what is mended,
 * and that nothing whatever comes out that is not a number. */
#include "screen_maker.h"

#include "base/kernel.h"

static const float nothing = -7;

typedef struct split_planes {
    float* plane[9]; /* attenuated, scattered, spread */
} split_planes;

static split_planes split(ty_context* context, const ty_screen_def* def, const picture* p) {
    split_planes s;
    const ty_screen_image image = image_of(p);
    for (int i = 0; i < 9; ++i) s.plane[i] = calloc((size_t)pixel_count(p), sizeof(float));
    assert_int_equal(ty_screen_split(context, def, &image, s.plane, s.plane + 3, s.plane + 6), TY_OK);
    return s;
}

static void free_split(split_planes* s) {
    for (int i = 0; i < 9; ++i) free(s->plane[i]);
}

static ty_screen_def coloured_fog(void) {
    ty_screen_def def = gray_fog(0, 0, 0, 300);
    set3f(def.sigma_s, 0.3, 0.1, 0.02);
    set3f(def.sigma_a, 0.01, 0.05, 0);
    set3f(def.g, 0.9, 0.5, -0.3);
    return def;
}

static void parts_add_up(void** state) {
    picture p = make_picture(67, 9, 1);
    fill_random(&p, 0.01, 300, 1);
    const ty_screen_def def = coloured_fog();
    split_planes s = split(*state, &def, &p);
    for (int c = 0; c < 3; ++c)
        for (int32_t i = 0; i < pixel_count(&p); ++i) {
            const double color = (double)p.color[c * pixel_count(&p) + i], d = (double)p.distance[i];
            const double absorbed = exp(-(double)def.sigma_a[c] * d), kept = exp(-(double)def.sigma_s[c] * d);
            const double attenuated = (double)s.plane[c][i], scattered = (double)s.plane[3 + c][i];
            assert_close(attenuated, color * absorbed * kept, 1e-5 * color * absorbed * kept + 1e-35);
            assert_close(attenuated + scattered, color * absorbed, 2e-6 * color * absorbed);
        }
    for (int32_t i = 0; i < 3 * pixel_count(&p); ++i) assert_close((double)p.out[i], -1, 0);
    free_split(&s);
    free_picture(&p);
}

/* Half of a Gaussian lies within sqrt(2 ln 2) standard deviations. */
static void spread_is_that_of_equation_2(void** state) {
    picture p = make_picture(40, 5, 1);
    fill_random(&p, 0.01, 300, 2);
    ty_screen_def def = coloured_fog();
    def.spread = TY_SCREEN_SPREAD_GAUSSIAN;
    split_planes s = split(*state, &def, &p);
    for (int c = 0; c < 3; ++c)
        for (int32_t i = 0; i < pixel_count(&p); ++i) {
            const double width = gaussian_spread((double)def.sigma_s[c], (double)def.sigma_a[c], (double)def.g[c],
                                                 (double)p.distance[i], 300);
            assert_close((double)s.plane[6 + c][i], sqrt(2 * log(2)) * width, 1e-5 * width);
        }
    free_split(&s);
    free_picture(&p);
}

/* Any plane may be left out, and those given have the layout of out. */
static void split_planes_may_be_left_out(void** state) {
    picture p = make_picture(3, 2, 5);
    fill_random(&p, 1, 10, 3);
    ty_screen_image image = image_of(&p);
    image.out = (ty_screen_planes){.step = 2, .row = 7};
    float plane[14];
    for (int i = 0; i < 14; ++i) plane[i] = nothing;
    float* const only_green[3] = {NULL, plane, NULL};
    const ty_screen_def def = coloured_fog();
    assert_int_equal(ty_screen_split(*state, &def, &image, NULL, only_green, NULL), TY_OK);
    for (int i = 0; i < 14; ++i) {
        const int x = i % 7 / 2, y = i / 7;
        if (i % 7 % 2 != 0 || x >= 3) {
            assert_close((double)plane[i], (double)nothing, 0);
            continue;
        }
        const double color = (double)p.color[6 + 3 * y + x], d = (double)p.distance[3 * y + x];
        assert_close((double)plane[i], color * exp(-0.05 * d) * -expm1(-0.1 * d), 1e-5 * color);
    }
    free_picture(&p);
}

static void planar_distances_are_cosines_shorter(void** state) {
    picture flat = make_picture(31, 17, 4), radial = make_picture(31, 17, 1);
    fill_color(&flat, 1, 2, 3);
    fill_color(&radial, 1, 2, 3);
    ty_screen_def def = gray_fog(0.2, 0.1, 0.5, 20);
    def.focal[1] = 30;
    def.center[0] = 3.5;
    def.center[1] = -40;
    for (int32_t i = 0; i < pixel_count(&radial); ++i) {
        const double dx = (i % 31 + 0.5 - 3.5) / 20, dy = (i / 31 + 0.5 + 40) / 30;
        radial.distance[i] = (float)(4 * sqrt(1 + dx * dx + dy * dy));
    }
    apply(*state, &def, &radial);
    def.distance_kind = TY_SCREEN_DISTANCE_AXIS;
    apply(*state, &def, &flat);
    for (int32_t i = 0; i < 3 * pixel_count(&flat); ++i)
        assert_close((double)flat.out[i], (double)radial.out[i], 1e-5 * (double)radial.out[i]);
    free_picture(&flat);
    free_picture(&radial);
}

/* ---- the environment ---- */

static void environment_adds_airlight(void** state) {
    picture p = make_picture(5, 4, 3);
    ty_screen_def def = coloured_fog();
    set3f(def.environment, 1, 2, 3);
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        ty_screen_def any = def;
        set_variant(&any, (variant)v);
        apply(*state, &any, &p);
        for (int c = 0; c < 3; ++c) {
            const double s = (double)def.sigma_s[c], t = s + (double)def.sigma_a[c];
            assert_close((double)p.out[20 * c + 7], (c + 1) * s / t * -expm1(-3 * t), 3e-6);
        }
    }
    free_picture(&p);
}

static double forward_share(double g) {
    enum { STEPS = 200000 };
    double sum = 0;
    for (int i = 0; i < STEPS; ++i) {
        const double mu = 1 - pow((i + 0.5) / STEPS, 3); /* dense where g near 1 is sharp */
        const double weight = 3 * pow((i + 0.5) / STEPS, 2) / STEPS;
        sum += weight * 0.5 * (1 - g * g) / pow(1 + g * g - 2 * g * mu, 1.5);
    }
    return sum;
}

static void balance_is_the_forward_half_space(void** state) {
    (void)state;
    static const double values[] = {-0.999, -0.9, -0.5, -1.1e-4, -0.9e-4, 0, 0.9e-4, 1.1e-4, 0.3, 0.8, 0.99};
    const float radiance[3] = {1, 10, 100};
    for (size_t i = 0; i < sizeof values / sizeof *values; ++i) {
        ty_screen_def def = gray_fog(1, 0, values[i], 100);
        ty_screen_balance(&def, radiance);
        for (int c = 0; c < 3; ++c) {
            assert_close((double)def.forward[c], forward_share(values[i]), 1e-5);
            assert_close((double)def.environment[c], (1 - (double)def.forward[c]) * (double)radiance[c],
                         1e-6 * (double)radiance[c]);
        }
    }
}

/* A uniform picture in a uniform environment without absorption: fog is invisible. */
static void white_furnace_stays_white(void** state) {
    static const double values[] = {-0.9, 0, 0.5, 0.99};
    static const double distances[] = {1e-3, 0.5, 3, 20, 1000};
    const float radiance[3] = {2, 3, 5};
    for (int v = 0; v < VARIANT_COUNT; ++v)
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 5; ++j) {
                if (v == PUBLISHED) continue; /* its masks take light away */
                picture p = make_picture(19, 13, distances[j]);
                fill_color(&p, 2, 3, 5);
                ty_screen_def def = gray_fog(0.4, 0, values[i], 50);
                set_variant(&def, (variant)v);
                def.window = 20;
                ty_screen_balance(&def, radiance);
                apply(*state, &def, &p);
                for (int32_t k = 0; k < 3 * pixel_count(&p); ++k)
                    assert_close((double)p.out[k], (double)p.color[k], 2e-5 * (double)p.color[k]);
                free_picture(&p);
            }
}

/* ---- what is not light or a distance ---- */

static void no_medium_gives_the_picture_back(void** state) {
    static const float odd[] = {-0.0f, 0.0f, 1e-45f, 1e-39f, 1.17549435e-38f, 1, 65504, 65505, 1e30f, 3.402823466e38f};
    picture p = make_picture(33, 7, 1);
    for (int32_t i = 0; i < 3 * pixel_count(&p); ++i) p.color[i] = odd[i % 10];
    for (int v = 0; v < VARIANT_COUNT; ++v) {
        ty_screen_def def = gray_fog(0, 0, 0, 10);
        set_variant(&def, (variant)v);
        set3f(def.environment, 5, 5, 5); /* nothing scatters it */
        const ty_screen_stats stats = apply(*state, &def, &p);
        assert_memory_equal(p.out, p.color, 3 * sizeof(float) * (size_t)pixel_count(&p));
        assert_int_equal(stats.nonfinite_fixed, 0);
        assert_int_equal(stats.missing_depth, 0);
    }
    free_picture(&p);
}

static float bad_value(int i) {
    static const uint32_t bits[] = {0x7f800000u, 0xff800000u, 0x7fc00000u, 0xffc00001u,
                                    0x7f800001u, 0xbf800000u, 0x8da24260u, 0xff7fffffu};
    return ty_float_from_bits(bits[i % 8]);
}

/* A picture with bad values gives what one gives where they are 0, or 65504 for +Inf, bit for bit; and they are counted
 * by pixels. */
static void bad_light_is_mended(void** state) {
    for (int medium = 0; medium < 2; ++medium)
        for (int v = 0; v < VARIANT_COUNT; ++v) {
            picture bad = make_picture(29, 11, 1), good = make_picture(29, 11, 1);
            fill_random(&bad, 1, 30, 4);
            fill_random(&good, 1, 30, 4);
            for (int32_t i = 0; i < 50; ++i) {
                const int32_t at = i * 6 + (i % 3) * pixel_count(&bad);
                bad.color[at] = bad_value(i);
                good.color[at] = i % 8 == 0 ? 65504.0f : 0.0f;
            }
            ty_screen_def def = gray_fog(medium * 0.05, medium * 0.01, 0.7, 40);
            set_variant(&def, (variant)v);
            const ty_screen_stats stats = apply(*state, &def, &bad);
            assert_int_equal(stats.nonfinite_fixed, 50);
            assert_int_equal(apply(*state, &def, &good).nonfinite_fixed, 0);
            assert_memory_equal(bad.out, good.out, 3 * sizeof(float) * (size_t)pixel_count(&bad));
            free_picture(&bad);
            free_picture(&good);
        }
}

static void unknown_distances_are_counted(void** state) {
    for (int medium = 0; medium < 2; ++medium)
        for (int v = 0; v < VARIANT_COUNT; ++v) {
            picture bad = make_picture(29, 11, 1), good = make_picture(29, 11, 1);
            fill_random(&bad, 1, 30, 5);
            fill_random(&good, 1, 30, 5);
            for (int32_t i = 0; i < 60; ++i) {
                bad.distance[5 * i] = i % 9 == 8 ? 0.0f : bad_value(i % 9);
                good.distance[5 * i] = 77;
            }
            ty_screen_def def = gray_fog(medium * 0.05, 0, 0.7, 40);
            set_variant(&def, (variant)v);
            def.missing_depth = 77;
            assert_int_equal(apply(*state, &def, &bad).missing_depth, 60);
            assert_int_equal(apply(*state, &def, &good).missing_depth, 0);
            assert_memory_equal(bad.out, good.out, 3 * sizeof(float) * (size_t)pixel_count(&bad));
            free_picture(&bad);
            free_picture(&good);
        }
}

/* ---- anything at all ---- */

static float any_bits(uint64_t* state) {
    return ty_float_from_bits((uint32_t)(uniform(state) * 0x1p32));
}

/* 0 now and then, else on a log scale. */
static double any_size(uint64_t* state, double least, double largest) {
    return uniform(state) < 0.15 ? least * (least > 1e-40) : least * pow(largest / least, uniform(state));
}

static double any_of(uint64_t* state, const double* values, int count) {
    return values[(int)(uniform(state) * count)];
}

static ty_screen_def any_def(uint64_t* state) {
    static const double cosines[] = {-0.99999994, -0.999, -0.3, 0, 1e-30, 0.5, 0.9999, 0.99999994};
    static const double filters[] = {2, 4, 6}, levels[] = {1, 2, 7, 15, TY_AUTO, TY_SCREEN_LEVELS_ALL};
    ty_screen_def def = ty_default_screen_def();
    for (int c = 0; c < 3; ++c) {
        def.sigma_s[c] = (float)(uniform(state) < 0.2 ? 0 : any_size(state, 1e-30, 1e15));
        def.sigma_a[c] = (float)(uniform(state) < 0.4 ? 0 : any_size(state, 1e-30, 1e15));
        def.g[c] = (float)any_of(state, cosines, 8);
        def.environment[c] = (float)any_size(state, 1e-30, 1e15);
        def.forward[c] = (float)uniform(state);
    }
    for (int axis = 0; axis < 2; ++axis) {
        def.focal[axis] = any_size(state, 1e-3, 1e9);
        if (uniform(state) < 0.5) def.center[axis] = uniform_in(state, -1, 1) * any_size(state, 1, 1e9);
    }
    def.distance_kind = uniform(state) < 0.5 ? TY_SCREEN_DISTANCE_AXIS : TY_SCREEN_DISTANCE_RAY;
    def.missing_depth = (float)any_size(state, 1e-20, 1e15);
    def.filter = (int32_t)any_of(state, filters, 3);
    def.levels = (int32_t)any_of(state, levels, 6);
    def.mask_width = (float)any_size(state, 1e-6, 1e6);
    def.level_scale = (float)any_size(state, 1e-3, 1e3);
    def.window = 1 + (int32_t)(uniform(state) * 12);
    return def;
}

static void nothing_gives_what_is_no_number(void** state) {
    uint64_t random = 6;
    for (int trial = 0; trial < 400; ++trial) {
        picture p = make_picture(1 + (int32_t)(uniform(&random) * 40), 1 + (int32_t)(uniform(&random) * 20), 1);
        const double wild = uniform(&random);
        fill_random(&p, 1e-3, 1e6, (uint64_t)trial);
        for (int32_t i = 0; i < 3 * pixel_count(&p); ++i)
            if (uniform(&random) < wild) p.color[i] = any_bits(&random);
        for (int32_t i = 0; i < pixel_count(&p); ++i)
            if (uniform(&random) < wild) p.distance[i] = any_bits(&random);
        const ty_screen_def def = any_def(&random);
        for (int v = 0; v < VARIANT_COUNT; ++v) {
            ty_screen_def any = def;
            set_variant(&any, (variant)v);
            const ty_screen_stats stats = apply(*state, &any, &p);
            for (int32_t i = 0; i < 3 * pixel_count(&p); ++i)
                if (!(p.out[i] >= 0 && p.out[i] <= 1e30f))
                    fail_msg("trial %d, %s: value %d of %d x %d is %g", trial, variant_names[v], i, p.width, p.height,
                             (double)p.out[i]);
            if (!(isfinite(stats.spread) && isfinite(stats.max_spread) && stats.max_spread >= 0))
                fail_msg("trial %d, %s: spread %g, at most %g", trial, variant_names[v], stats.spread,
                         stats.max_spread);
        }
        free_picture(&p);
    }
}

/* The brightest light that is not mended, spread as widely as can be, keeps its sum. */
static void brightest_light_does_not_overflow(void** state) {
    picture p = make_picture(32, 32, 1e9);
    fill_color(&p, 9e28, 3e28, 1);
    for (int v = SMALL_ANGLE; v <= GAUSSIAN; ++v) {
        ty_screen_def def = gray_fog(1e3, 0, 0.3, 1e6);
        set_variant(&def, (variant)v);
        apply(*state, &def, &p);
        for (int32_t i = 0; i < 3 * pixel_count(&p); ++i)
            assert_close((double)p.out[i], (double)p.color[i], 1e-5 * (double)p.color[i]);
        assert_true(isfinite(apply(*state, &def, &p).spread));
    }
    free_picture(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_add_up),
        cmocka_unit_test(spread_is_that_of_equation_2),
        cmocka_unit_test(split_planes_may_be_left_out),
        cmocka_unit_test(planar_distances_are_cosines_shorter),
        cmocka_unit_test(environment_adds_airlight),
        cmocka_unit_test(balance_is_the_forward_half_space),
        cmocka_unit_test(white_furnace_stays_white),
        cmocka_unit_test(no_medium_gives_the_picture_back),
        cmocka_unit_test(bad_light_is_mended),
        cmocka_unit_test(unknown_distances_are_counted),
        cmocka_unit_test(nothing_gives_what_is_no_number),
        cmocka_unit_test(brightest_light_does_not_overflow),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
