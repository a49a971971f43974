/* Environments: which way they face, lookup, and sampling in proportion to brightness. */
#include "checks.h"

#include "scene/lights/environment.h"

static const double pi = 3.14159265358979323846;

typedef struct setting {
    ty_axis up;
    double rotation;
} setting;

static const setting settings[] = {
    {TY_AXIS_Y, 0}, {TY_AXIS_Z, 0}, {TY_AXIS_Y, 37}, {TY_AXIS_Z, 90}, {TY_AXIS_Y, -35977}};
enum { SETTINGS = sizeof settings / sizeof *settings };

/* An environment and its view. */
typedef struct sky {
    ty_context* context;
    ty_environment* environment;
    ty_environment_view view;
    setting setting;
} sky;

/* pixels: width x height x 3, or NULL for a constant. */
static sky make_sky(ty_context* context, int32_t width, int32_t height, const float* pixels, setting s) {
    sky out = {.context = context, .setting = s};
    ty_light_def def = ty_default_light_def();
    def.kind = TY_LIGHT_ENVIRONMENT;
    def.rotation = s.rotation;
    ty_image* image = NULL;
    if (pixels != NULL) {
        assert_int_equal(ty_image_create_rgb(context, width, height, &image), TY_OK);
        for (int c = 0; c < 3; ++c)
            for (int32_t i = 0; i < width * height; ++i) ty_image_plane(image, c)[i] = pixels[3 * i + c];
        def.image = image;
    }
    assert_int_equal(ty_environment_create(context, &def, NULL, &out.environment), TY_OK);
    ty_image_destroy(image);
    out.view = ty_environment_get_view(out.environment, s.up);
    return out;
}

static void destroy_sky(sky* s) {
    ty_environment_destroy(s->context, s->environment);
}

/* Random pixels, a few of them a hundred times brighter. */
static float* random_pixels(int32_t width, int32_t height) {
    uint64_t random = 41;
    float* pixels = malloc(sizeof *pixels * 3 * (size_t)width * (size_t)height);
    assert_non_null(pixels);
    for (int32_t i = 0; i < width * height; ++i) {
        const double bright = uniform(&random) < 0.02 ? 100 : 1;
        for (int c = 0; c < 3; ++c) pixels[3 * i + c] = (float)(bright * uniform_in(&random, 0.1, 1));
    }
    return pixels;
}

/* Where map coordinates lie, as the design states it: y up u = 0.5 + atan2(z, x) / 2 pi, z up u = 0.5 - atan2(y, x) / 2
 * pi, v = 0 at the top; then turned counter-clockwise seen from above. */
static ty_vec direction_of(setting s, double u, double v) {
    const double angle = 2 * pi * (u - 0.5), height = cos(pi * v), across = sin(pi * v);
    const double turn = s.rotation * pi / 180;
    if (s.up == TY_AXIS_Y) {
        const double x = across * cos(angle), z = across * sin(angle);
        return ty_vec_make((float)(x * cos(turn) + z * sin(turn)), (float)height,
                           (float)(z * cos(turn) - x * sin(turn)));
    }
    const double x = across * cos(-angle), y = across * sin(-angle);
    return ty_vec_make((float)(x * cos(turn) - y * sin(turn)), (float)(x * sin(turn) + y * cos(turn)), (float)height);
}

static void angles_are_close_to_libm(void** state) {
    (void)state;
    uint64_t random = 42;
    double worst = 0;
    for (int i = 0; i < 200000; ++i) {
        const double angle = uniform_in(&random, -pi, pi), r = exp(uniform_in(&random, -20, 20));
        const float y = (float)(r * sin(angle)), x = (float)(r * cos(angle));
        worst = fmax(worst, fabs((double)ty_atan2_over_2pi(y, x) - atan2((double)y, (double)x) / (2 * pi)));
    }
    if (worst > 2e-6) fail_msg("error %g turns", worst);
    assert_true(ty_atan2_over_2pi(0, 0) == 0);
    assert_close(ty_atan2_over_2pi(0, -1), 0.5, 0);
    assert_close(ty_atan2_over_2pi(-1, 0), -0.25, 1e-7);
}

static void texels_lie_where_the_design_says(void** state) {
    enum { W = 8, H = 4 };
    float pixels[3 * W * H], found[3];
    for (int i = 0; i < 3 * W * H; ++i) pixels[i] = (float)(i % 3 * 100 + i / 3);
    for (int n = 0; n < SETTINGS; ++n) {
        sky s = make_sky(*state, W, H, pixels, settings[n]);
        for (int y = 0; y < H; ++y)
            for (int x = 0; x < W; ++x) {
                ty_environment_radiance(&s.view, direction_of(settings[n], (x + 0.5) / W, (y + 0.5) / H), found);
                for (int c = 0; c < 3; ++c) assert_close(found[c], pixels[3 * (x + W * y) + c], 2e-3);
            }
        destroy_sky(&s);
    }
}

/* The centre of the map is along +x, and a quarter turn takes it to -z (y up) or +y (z up). */
static void the_centre_is_along_x(void** state) {
    float pixels[3 * 5] = {0, 0, 0, 0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0}, found[3];
    static const setting cases[] = {{TY_AXIS_Y, 0}, {TY_AXIS_Z, 0}, {TY_AXIS_Y, 90}, {TY_AXIS_Z, 90}};
    static const float ways[][3] = {{1, 0, 0}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
    for (int i = 0; i < 4; ++i) {
        sky s = make_sky(*state, 5, 1, pixels, cases[i]);
        ty_environment_radiance(&s.view, ty_vec_load(ways[i]), found);
        assert_close(found[0], 1, 1e-4);
        ty_environment_radiance(&s.view, ty_scale(ty_vec_load(ways[i]), -1), found);
        assert_close(found[0], 0, 1e-4);
        destroy_sky(&s);
    }
}

static void lookups_are_bilinear_and_wrap_around(void** state) {
    enum { W = 7, H = 5 };
    uint64_t random = 43;
    float* pixels = random_pixels(W, H);
    sky s = make_sky(*state, W, H, pixels, settings[0]);
    for (int n = 0; n < 5000; ++n) {
        const double u = uniform(&random), v = uniform(&random);
        float found[3];
        ty_environment_radiance(&s.view, direction_of(settings[0], u, v), found);
        const double x = u * W - 0.5, y = fmin(fmax(v * H - 0.5, 0), H - 1);
        double expected = 0;
        for (int corner = 0; corner < 4; ++corner) {
            const int cx = (int)floor(x) + (corner & 1), cy = (int)fmin(floor(y) + (corner >> 1), H - 1);
            const double wx = corner & 1 ? x - floor(x) : 1 - x + floor(x),
                         wy = corner & 2 ? y - floor(y) : 1 - y + floor(y);
            expected += wx * wy * (double)pixels[3 * ((cx + W) % W + W * cy)];
        }
        assert_close(found[0], expected, 5e-3);
    }
    for (double v = 0.05; v < 1; v += 0.1) {
        float left[3], right[3];
        ty_environment_radiance(&s.view, direction_of(settings[0], 1e-6, v), left);
        ty_environment_radiance(&s.view, direction_of(settings[0], 1 - 1e-6, v), right);
        assert_close(left[0], right[0], 5e-3);
    }
    destroy_sky(&s);
    free(pixels);
}

/* ---- sampling ---- */

/* Sums of pdf and of radiance over the sphere; the midpoint rule with `fine` points per table cell and axis. */
static void integrate(const sky* s, int fine, double* pdf, double* radiance) {
    const int w = s->view.table_width * fine, h = s->view.table_height * fine;
    *pdf = *radiance = 0;
    for (int y = 0; y < h; ++y) {
        const double solid_angle = 2 * pi / w * (cos(pi * y / h) - cos(pi * (y + 1) / h));
        for (int x = 0; x < w; ++x) {
            const ty_vec look = direction_of(s->setting, (x + 0.5) / w, (y + 0.5) / h);
            float rgb[3];
            ty_environment_radiance(&s->view, look, rgb);
            *pdf += solid_angle * (double)ty_environment_pdf(&s->view, look);
            *radiance += solid_angle * (double)rgb[1];
        }
    }
}

/* Samples agree with the density, and give the map's integral without bias. */
static void check_sampling(const sky* s, double integral) {
    const int count = 20000;
    uint64_t random = 44;
    int differing = 0;
    double sum = 0, square = 0;
    for (int i = 0; i < count; ++i) {
        ty_vec look;
        float rgb[3];
        const float pdf = ty_environment_sample(&s->view, (float)(uniform(&random) * 0.99999994),
                                                (float)(uniform(&random) * 0.99999994), &look);
        assert_close(ty_dot(look, look), 1, 2e-6);
        assert_true(pdf > 0);
        differing += fabsf(ty_environment_pdf(&s->view, look) / pdf - 1) > 1e-3f;
        ty_environment_radiance(&s->view, look, rgb);
        const double value = (double)(rgb[1] / pdf);
        sum += value;
        square += value * value;
    }
    /* Only directions on the line between two cells may be taken for the neighbour. */
    assert_true(differing < count / 100);
    const double mean = sum / count, variance = fmax(square / count - mean * mean, 0) / count;
    assert_close(mean, integral, 4.5 * sqrt(variance) + 2e-3 * integral);
}

static void densities_integrate_to_one(void** state) {
    static const int32_t sizes[][2] = {{1, 1}, {2, 1}, {1, 2}, {16, 8}, {13, 7}, {64, 64}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        float* pixels = random_pixels(sizes[i][0], sizes[i][1]);
        for (int n = 0; n < SETTINGS; ++n) {
            sky s = make_sky(*state, sizes[i][0], sizes[i][1], pixels, settings[n]);
            double pdf, radiance;
            integrate(&s, sizes[i][0] < 10 ? 64 : 8, &pdf, &radiance);
            assert_close(pdf, 1, 2e-4);
            check_sampling(&s, radiance);
            destroy_sky(&s);
        }
        free(pixels);
    }
}

/* Tables are at most 512 x 256; a cell of theirs then stands for several texels. */
static void maps_larger_than_the_tables(void** state) {
    static const int32_t sizes[][2] = {{1024, 512}, {1023, 511}, {513, 100}, {300, 301}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        float* pixels = random_pixels(sizes[i][0], sizes[i][1]);
        sky s = make_sky(*state, sizes[i][0], sizes[i][1], pixels, settings[(i + 2) % SETTINGS]);
        assert_true(s.view.table_width <= 512 && s.view.table_height <= 256);
        double pdf, radiance;
        integrate(&s, 2, &pdf, &radiance);
        assert_close(pdf, 1, 1e-3);
        /* 300 x 301 and the like have texels that the midpoint rule misses: the mean over texels is exact but for them.
         */
        assert_close(s.environment->mean[1] * (float)(4 * pi), radiance, 0.02 * radiance);
        check_sampling(&s, (double)s.environment->mean[1] * 4 * pi);
        destroy_sky(&s);
        free(pixels);
    }
}

static void samples_follow_the_density(void** state) {
    enum { W = 12, H = 6, COUNT = 100000 };
    float* pixels = random_pixels(W, H);
    for (int n = 0; n < SETTINGS; ++n) {
        sky s = make_sky(*state, W, H, pixels, settings[n]);
        uint64_t random = 45;
        double counts[W * H] = {0}, chi = 0, total = 0;
        for (int i = 0; i < COUNT; ++i) {
            ty_vec look;
            float u, v;
            ty_environment_sample(&s.view, (float)(uniform(&random) * 0.9999999), (float)(uniform(&random) * 0.9999999),
                                  &look);
            ty_environment_uv(&s.view, look, &u, &v);
            ++counts[(int)fmin((double)u * W, W - 1) + W * (int)fmin((double)v * H, H - 1)];
        }
        for (int y = 0; y < H; ++y)
            for (int x = 0; x < W; ++x) {
                const ty_vec look = direction_of(settings[n], (x + 0.5) / W, (y + 0.5) / H);
                const double solid_angle = 2 * pi / W * (cos(pi * y / H) - cos(pi * (y + 1) / H));
                const double expected = COUNT * solid_angle * (double)ty_environment_pdf(&s.view, look);
                chi += (counts[x + W * y] - expected) * (counts[x + W * y] - expected) / expected;
                total += expected;
            }
        assert_close(total, COUNT, 1e-3 * COUNT);
        if (chi > W * H - 1 + 4.5 * sqrt(2.0 * (W * H - 1))) fail_msg("chi-square %g", chi);
        destroy_sky(&s);
    }
    free(pixels);
}

/* One bright texel in the dark: all samples go near it, and no lit direction is without a share. */
static void samples_go_where_light_is(void** state) {
    enum { W = 32, H = 16 };
    float pixels[3 * W * H] = {0};
    for (int c = 0; c < 3; ++c) pixels[3 * (31 + W * 5) + c] = 10;
    sky s = make_sky(*state, W, H, pixels, settings[0]);
    const ty_vec bright = direction_of(settings[0], 31.5 / W, 5.5 / H);
    uint64_t random = 46;
    for (int i = 0; i < 20000; ++i) {
        ty_vec look;
        float rgb[3];
        ty_environment_sample(&s.view, (float)uniform_in(&random, 0, 0.9999), (float)uniform_in(&random, 0, 0.9999),
                              &look);
        assert_true(ty_dot(look, bright) > cosf(2.5f * (float)pi / H));
        look = random_unit(&random);
        ty_environment_radiance(&s.view, look, rgb);
        if (rgb[0] > 1e-3f) assert_true(ty_environment_pdf(&s.view, look) > 0);
    }
    destroy_sky(&s);
}

static void the_ends_of_the_unit_square_are_sampled(void** state) {
    static const float ends[] = {0, 0x1.fffffep-1f};
    float* pixels = random_pixels(9, 5);
    sky s = make_sky(*state, 9, 5, pixels, settings[1]);
    for (int i = 0; i < 4; ++i) {
        ty_vec look;
        assert_true(ty_environment_sample(&s.view, ends[i & 1], ends[i >> 1], &look) > 0);
        assert_close(ty_dot(look, look), 1, 2e-6);
    }
    destroy_sky(&s);
    free(pixels);
}

static void black_maps_are_dark_and_harmless(void** state) {
    float pixels[3 * 8 * 4] = {0};
    sky s = make_sky(*state, 8, 4, pixels, settings[0]);
    double pdf, radiance;
    integrate(&s, 8, &pdf, &radiance);
    assert_close(pdf, 1, 1e-4);
    assert_true(radiance == 0 && s.environment->mean[0] == 0);
    check_sampling(&s, 0);
    destroy_sky(&s);
}

static void one_texel_is_everywhere(void** state) {
    const float pixel[3] = {1, 2, 3};
    float found[3];
    uint64_t random = 47;
    sky s = make_sky(*state, 1, 1, pixel, settings[2]);
    for (int i = 0; i < 1000; ++i) {
        const ty_vec look = random_unit(&random);
        ty_environment_radiance(&s.view, look, found);
        for (int c = 0; c < 3; ++c) assert_true(found[c] == pixel[c]);
        assert_close(ty_environment_pdf(&s.view, look), 1 / (4 * pi), 1e-6);
    }
    for (int c = 0; c < 3; ++c) assert_close(s.environment->mean[c], pixel[c], 1e-6);
    destroy_sky(&s);
}

static void constants_have_no_map(void** state) {
    sky s = make_sky(*state, 0, 0, NULL, settings[1]);
    float found[3];
    ty_vec look;
    ty_environment_radiance(&s.view, ty_vec_make(0, 0, 1), found);
    assert_true(found[0] == 1 && found[1] == 1 && found[2] == 1);
    assert_close(ty_environment_sample(&s.view, 0.25f, 0.5f, &look), 1 / (4 * pi), 1e-7);
    assert_close(look.z, 0.5, 1e-6);
    assert_close(ty_environment_pdf(&s.view, look), 1 / (4 * pi), 1e-7);
    check_sampling(&s, 4 * pi);
    destroy_sky(&s);
}

static void scale_multiplies_the_map(void** state) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create_rgb(*state, 2, 2, &image), TY_OK);
    for (int i = 0; i < 4; ++i) ty_image_plane(image, 0)[i] = 2;
    ty_light_def def = ty_default_light_def();
    def.kind = TY_LIGHT_ENVIRONMENT;
    def.image = image;
    def.scale = 3;
    ty_environment* environment = NULL;
    assert_int_equal(ty_environment_create(*state, &def, NULL, &environment), TY_OK);
    const ty_environment_view view = ty_environment_get_view(environment, TY_AXIS_Y);
    float found[3];
    ty_environment_radiance(&view, ty_vec_make(0, 1, 0), found);
    assert_close(found[0], 6, 1e-6);
    assert_close(environment->mean[0], 6, 1e-6);
    assert_true(ty_environment_map_bytes(environment->map) > 12 * sizeof(float));
    ty_environment_destroy(*state, environment);
    ty_environment_destroy(*state, NULL);
    ty_image_destroy(image);
}

/* An image beside its frame gives the map that fills the frame. */
static void a_map_is_the_frame_of_its_image(void** state) {
    ty_light_def def = ty_default_light_def();
    def.kind = TY_LIGHT_ENVIRONMENT;
    ty_image* image = NULL;
    assert_int_equal(ty_image_create_rgb(*state, 3, 2, &image), TY_OK);
    assert_int_equal(ty_image_set_frame(image, 6, 1, 8, 4), TY_OK);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 6; ++i) ty_image_plane(image, c)[i] = 1 + (float)i;
    def.image = image;
    ty_environment* environment = NULL;
    assert_int_equal(ty_environment_create(*state, &def, NULL, &environment), TY_OK);
    ty_image_destroy(image);
    const ty_environment_view view = ty_environment_get_view(environment, TY_AXIS_Y);
    assert_int_equal(view.width, 8);
    assert_int_equal(view.height, 4);
    for (int i = 0; i < 32; ++i) {
        const int x = i % 8 - 6, y = i / 8 - 1;
        const float expected = x >= 0 && x < 2 && y >= 0 && y < 2 ? (float)(1 + x + 3 * y) : 0;
        assert_true(view.pixels[3 * i] == expected && view.pixels[3 * i + 2] == expected);
    }
    ty_environment_destroy(*state, environment);
}

static void pixels_that_are_not_light_count_as_zero(void** state) {
    const float pixels[12] = {NAN, 1, 1, -2, 1, 1, INFINITY, 1, 1, 5, 1, 1};
    sky s = make_sky(*state, 2, 2, pixels, settings[0]);
    assert_close(s.environment->mean[0], 1.25, 1e-6);
    assert_close(s.environment->mean[1], 1, 1e-6);
    destroy_sky(&s);
}

/* Cells hold the whole sphere and all its light, in whichever way they come about; and where it comes from. */
static void cells_hold_all_light(void** state) {
    static const int32_t sizes[5][2] = {{300, 150}, {512, 256}, {1000, 500}, {256, 100}, {16, 8}};
    for (int n = 0; n < SETTINGS * 6; ++n) {
        const int32_t* size = sizes[n / SETTINGS % 5];
        float* pixels = n / SETTINGS < 5 ? random_pixels(size[0], size[1]) : NULL;
        sky s = make_sky(*state, size[0], size[1], pixels, settings[n % SETTINGS]);
        double color[3] = {0, 0, 0}, flow[3] = {0, 0, 0}, expected[3] = {0, 0, 0}, solid_angle = 0;
        assert_true(s.view.cells_width <= 256 && s.view.cells_height <= 128);
        for (int32_t i = 0; i < s.view.cells_width * s.view.cells_height; ++i) {
            for (int c = 0; c < 3; ++c) color[c] += (double)s.view.cells[i].color[c];
            for (int a = 0; a < 3; ++a) flow[a] += (double)s.view.cells[i].vector_luminance[a];
            solid_angle += (double)s.view.cells[i].solid_angle;
        }
        assert_close(solid_angle, 4 * pi, 1e-4);
        const double tolerance = pixels != NULL && size[1] < 128 ? 0.02 : 1e-4; /* lookups blend texels */
        for (int c = 0; c < 3; ++c) assert_close(color[c] / (4 * pi * (double)s.environment->mean[c]), 1, tolerance);
        for (int32_t i = 0; i < 512 * 256; ++i) {
            const double u = (i % 512 + 0.5) / 512, v = ((double)(i / 512) + 0.5) / 256;
            const ty_vec look = direction_of(s.setting, u, v);
            float rgb[3];
            ty_environment_radiance(&s.view, look, rgb);
            const double weight = sin(pi * v) * 2 * pi * pi / (512 * 256);
            const double bright =
                weight * (0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2]);
            const bool z_up = s.setting.up == TY_AXIS_Z;
            expected[0] += bright * (double)look.x;
            expected[1] += bright * (double)(z_up ? look.y : -look.z);
            expected[2] += bright * (double)(z_up ? look.z : look.y);
        }
        const double all = 4 * pi * (double)s.environment->mean[1];
        for (int a = 0; a < 3; ++a) assert_close(flow[a] / all, expected[a] / all, 0.01);
        destroy_sky(&s);
        free(pixels);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(angles_are_close_to_libm),
        cmocka_unit_test(texels_lie_where_the_design_says),
        cmocka_unit_test(the_centre_is_along_x),
        cmocka_unit_test(lookups_are_bilinear_and_wrap_around),
        cmocka_unit_test(densities_integrate_to_one),
        cmocka_unit_test(maps_larger_than_the_tables),
        cmocka_unit_test(samples_follow_the_density),
        cmocka_unit_test(samples_go_where_light_is),
        cmocka_unit_test(the_ends_of_the_unit_square_are_sampled),
        cmocka_unit_test(black_maps_are_dark_and_harmless),
        cmocka_unit_test(one_texel_is_everywhere),
        cmocka_unit_test(constants_have_no_map),
        cmocka_unit_test(scale_multiplies_the_map),
        cmocka_unit_test(a_map_is_the_frame_of_its_image),
        cmocka_unit_test(pixels_that_are_not_light_count_as_zero),
        cmocka_unit_test(cells_hold_all_light),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
