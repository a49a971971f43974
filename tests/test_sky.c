/* The sky: where things are on the map, what colours they have, and that light adds up. */
#include "checks.h"
#include "effort.h"

#include "scene/lights/sky.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* A sky with the sun seen at an elevation above x, turned by azimuth from x towards z (y up) or towards -y (z up). */
static ty_sky_def sun_at(double elevation_deg, double azimuth_deg, ty_axis up) {
    ty_sky_def def = ty_default_sky_def();
    const double e = elevation_deg * pi / 180, a = azimuth_deg * pi / 180;
    const double x = cos(e) * cos(a), side = cos(e) * sin(a), rise = sin(e);
    def.up_axis = up;
    def.width = 128;
    def.sun_direction[0] = -x;
    def.sun_direction[1] = up == TY_AXIS_Y ? -rise : side;
    def.sun_direction[2] = up == TY_AXIS_Y ? -side : -rise;
    return def;
}

/* Tables of the last atmosphere, which save most of the time of skies of the same one. */
static ty_sky_table kept_table;

static ty_image* make_sky(ty_context* context, const ty_sky_def* def, float sun[3]) {
    ty_image* image = NULL;
    assert_int_equal(ty_sky_create_image_with(context, def, &kept_table, &image, sun), TY_OK);
    assert_int_equal(ty_image_width(image), def->width);
    assert_int_equal(ty_image_height(image), def->width / 2);
    return image;
}

static double pixel(const ty_image* image, int32_t x, int32_t y, int32_t channel) {
    const float* plane = ty_image_plane_const(image, channel);
    return (double)plane[(size_t)y * (size_t)ty_image_width(image) + (size_t)x];
}

static double brightness(const ty_image* image, int32_t x, int32_t y) {
    return pixel(image, x, y, 0) + pixel(image, x, y, 1) + pixel(image, x, y, 2);
}

/* The direction one looks along at a pixel, by the map's convention: y up u = 0.5 + atan2(z, x) / 2 pi, z up
 * u = 0.5 - atan2(y, x) / 2 pi, v = 0 at the top. */
static void look_at_pixel(const ty_image* image, ty_axis up, int32_t x, int32_t y, double look[3]) {
    const double turn = 2 * pi * ((x + 0.5) / ty_image_width(image) - 0.5);
    const double down = pi * (y + 0.5) / ty_image_height(image);
    look[0] = sin(down) * cos(turn);
    look[1] = up == TY_AXIS_Y ? cos(down) : -sin(down) * sin(turn);
    look[2] = up == TY_AXIS_Y ? sin(down) * sin(turn) : cos(down);
}

static void threads_do_not_matter(void** state) {
    (void)state;
    ty_context* contexts[2] = {make_context(1), make_context(3)};
    ty_image* images[2];
    const ty_sky_def def = sun_at(25, 70, TY_AXIS_Y);
    for (int i = 0; i < 2; ++i) assert_int_equal(ty_sky_create_image(contexts[i], &def, &images[i], NULL), TY_OK);
    for (int c = 0; c < 3; ++c)
        assert_memory_equal(ty_image_plane(images[0], c), ty_image_plane(images[1], c), 128 * 64 * sizeof(float));
    for (int i = 0; i < 2; ++i) {
        ty_image_destroy(images[i]);
        ty_context_destroy(contexts[i]);
    }
}

/* Tables that were kept make no difference, whatever they were made for, and the sky differs by how it scatters. */
static void kept_tables_do_not_matter(void** state) {
    skip_under_sanitizers();
    ty_context* context = *state;
    const ty_sky_def first = sun_at(25, 70, TY_AXIS_Y);
    ty_sky_def defs[5] = {sun_at(60, 0, TY_AXIS_Y), first, first, first, first};
    defs[1].ground[1] = 0.7f, defs[2].ozone = 0, defs[3].scattering = TY_SKY_ISOTROPIC, defs[4].haze = 2;
    ty_image* expected = NULL;
    assert_int_equal(ty_sky_create_image(context, &first, &expected, NULL), TY_OK);
    for (int i = 0; i < (in_full() ? 5 : 2); ++i) {
        ty_image *other = make_sky(context, &defs[i], NULL), *again = make_sky(context, &first, NULL);
        assert_memory_equal(ty_image_plane(again, 1), ty_image_plane(expected, 1), 128 * 64 * sizeof(float));
        assert_memory_not_equal(ty_image_plane(other, 1), ty_image_plane(expected, 1), 128 * 64 * sizeof(float));
        ty_image_destroy(other);
        ty_image_destroy(again);
    }
    ty_image_destroy(expected);
}

static void radiance_is_finite_everywhere(void** state) {
    ty_context* context = *state;
    const double elevations[] = {-90, -30, -5, -0.3, 0, 0.3, 5, 45, 90}, hazes[] = {0, 1, 10};
    for (size_t h = 0; h < 3; ++h)
        for (size_t e = 0; e < sizeof elevations / sizeof *elevations; ++e) {
            ty_sky_def def = sun_at(elevations[e], 200, TY_AXIS_Z);
            def.haze = hazes[h];
            def.width = 34; /* an odd height: one row lies on the horizon */
            float sun[3];
            ty_image* image = make_sky(context, &def, sun);
            for (int c = 0; c < 3; ++c) {
                for (int i = 0; i < 34 * 17; ++i) {
                    const float value = ty_image_plane(image, c)[i];
                    assert_true(value >= 0 && value < 20);
                    if (elevations[e] >= 0 && i < 34 * 8) assert_true(value > 0);
                }
                assert_true(elevations[e] > 0 ? sun[c] > 0 && sun[c] < 1.5f : sun[c] == 0);
            }
            ty_image_destroy(image);
        }
}

/* Above the haze of the horizon the brightest pixel looks at the sun, give or take a pixel, for both up axes. */
static void the_sky_is_brightest_around_the_sun(void** state) {
    ty_context* context = *state;
    for (int up = TY_AXIS_Y; up <= TY_AXIS_Z; ++up)
        for (double azimuth = 20; azimuth < 360; azimuth += 55) {
            ty_sky_def def = sun_at(41, azimuth, (ty_axis)up);
            def.haze = 3;
            ty_image* image = make_sky(context, &def, NULL);
            int32_t best[2] = {0, 0};
            for (int32_t y = 0; y < 25; ++y)
                for (int32_t x = 0; x < 128; ++x)
                    if (brightness(image, x, y) > brightness(image, best[0], best[1])) best[0] = x, best[1] = y;
            double look[3], cosine = 0;
            look_at_pixel(image, (ty_axis)up, best[0], best[1], look);
            for (int a = 0; a < 3; ++a) cosine -= look[a] * def.sun_direction[a];
            assert_true(cosine > cos(4.5 * pi / 180));
            ty_image_destroy(image);
        }
}

/* The map of a scene with z up is that of the scene turned to y up, (x, y, z) -> (x, z, -y). */
static void up_axes_agree(void** state) {
    ty_context* context = *state;
    const ty_sky_def y_up = sun_at(30, 77, TY_AXIS_Y), z_up = sun_at(30, 77, TY_AXIS_Z);
    ty_image* a = make_sky(context, &y_up, NULL);
    ty_image* b = make_sky(context, &z_up, NULL);
    for (int c = 0; c < 3; ++c)
        assert_memory_equal(ty_image_plane(a, c), ty_image_plane(b, c), 128 * 64 * sizeof(float));
    ty_image_destroy(a);
    ty_image_destroy(b);
}

static void the_sky_is_symmetric_about_the_sun(void** state) {
    ty_context* context = *state;
    const ty_sky_def def = sun_at(20, 0, TY_AXIS_Y);
    ty_image* image = make_sky(context, &def, NULL);
    for (int c = 0; c < 3; ++c)
        for (int32_t y = 0; y < 64; ++y)
            for (int32_t x = 0; x < 64; ++x) {
                const double left = pixel(image, x, y, c), right = pixel(image, 127 - x, y, c);
                assert_true(fabs(left - right) <= 1e-5 * right);
            }
    assert_true(brightness(image, 63, 20) > 1.5 * brightness(image, 0, 20));
    ty_image_destroy(image);
}

static void colours_are_those_of_the_day(void** state) {
    ty_context* context = *state;
    float sun[3];
    const ty_sky_def noon = sun_at(70, 0, TY_AXIS_Y);
    ty_image* image = make_sky(context, &noon, sun);
    const double zenith[3] = {pixel(image, 0, 0, 0), pixel(image, 0, 0, 1), pixel(image, 0, 0, 2)};
    assert_true(zenith[2] > 1.6 * zenith[1] && zenith[1] > 1.3 * zenith[0]);
    assert_true(sun[0] > sun[1] && sun[1] > sun[2] && sun[2] > 0.7f * sun[0]);
    /* The horizon is brighter and whiter than the zenith. */
    assert_true(brightness(image, 0, 31) > 2 * brightness(image, 0, 0));
    assert_true(pixel(image, 0, 31, 2) / pixel(image, 0, 31, 0) < 0.6 * zenith[2] / zenith[0]);
    const double noon_zenith = brightness(image, 0, 0);
    ty_image_destroy(image);

    const ty_sky_def evening = sun_at(2, 0, TY_AXIS_Y);
    image = make_sky(context, &evening, sun);
    assert_true(sun[0] > 3 * sun[1] && sun[1] > 5 * sun[2] && sun[2] > 0);
    assert_true(pixel(image, 64, 31, 0) > 2 * pixel(image, 64, 31, 2));
    assert_true(pixel(image, 0, 0, 2) > pixel(image, 0, 0, 0));
    ty_image_destroy(image);

    const ty_sky_def dusk = sun_at(-4, 0, TY_AXIS_Y), night = sun_at(-30, 0, TY_AXIS_Y);
    image = make_sky(context, &dusk, sun);
    assert_true(brightness(image, 0, 0) > 0 && brightness(image, 0, 0) < 0.05 * noon_zenith);
    assert_true(brightness(image, 64, 31) > 5 * brightness(image, 0, 31));
    ty_image_destroy(image);
    image = make_sky(context, &night, sun);
    assert_true(brightness(image, 0, 0) < 1e-6 * noon_zenith);
    ty_image_destroy(image);
}

/* Straight up, optical depth is density at the ground times scale height, constituent by constituent; at 45 degrees the
 * atmosphere is still nearly flat. */
static void the_sun_has_its_irradiance(void** state) {
    skip_under_sanitizers();
    ty_context* context = *state;
    const double air[3] = {5.8e-6, 13.5e-6, 33.1e-6}, ozone[3] = {0.65e-6, 1.881e-6, 0.085e-6};
    for (double haze = 0; haze <= 4; haze += 2) {
        ty_sky_def up = sun_at(90, 0, TY_AXIS_Y), slant = sun_at(45, 130, TY_AXIS_Y);
        up.width = slant.width = 16;
        up.haze = slant.haze = haze;
        up.solar[0] = slant.solar[0] = 3;
        float sun[3], low[3];
        ty_image_destroy(make_sky(context, &up, sun));
        ty_image_destroy(make_sky(context, &slant, low));
        for (int c = 0; c < 3; ++c) {
            const double solar = c == 0 ? 3 : 1.5;
            const double depth = air[c] * 8000 + haze * 4e-6 / 0.9 * 1200 + ozone[c] * 15e3;
            assert_true(fabs((double)sun[c] / (solar * exp(-depth)) - 1) < 5e-4);
            assert_true(fabs((double)low[c] / (solar * exp(-depth * sqrt(2))) - 1) < 3e-3);
        }
    }
}

/* Irradiance of a level plane from the sky alone. */
static double sky_irradiance(const ty_image* image, int32_t channel) {
    double sum = 0;
    for (int32_t y = 0; y < 32; ++y) {
        const double down = pi * (y + 0.5) / 64;
        for (int32_t x = 0; x < 128; ++x)
            sum += pixel(image, x, y, channel) * cos(down) * sin(down) * (pi / 64) * (2 * pi / 128);
    }
    return sum;
}

/* Air alone absorbs next to nothing: what the direct light lost is in the sky or went back to space. Over a black
 * ground about half comes down; over a white one the
 * sky gets most of the light a second time. */
static void light_adds_up(void** state) {
    skip_under_sanitizers();
    ty_context* context = *state;
    float sun[3];
    ty_sky_def def = sun_at(60, 0, TY_AXIS_Y);
    def.haze = 0;
    for (int c = 0; c < 3; ++c) def.ground[c] = 0;
    ty_image* black = make_sky(context, &def, sun);
    for (int c = 0; c < 3; ++c) def.ground[c] = 1;
    ty_image* white = make_sky(context, &def, NULL);
    const double scattered = (1.5 - (double)sun[2]) * sin(pi / 3);
    const double down = sky_irradiance(black, 2);
    assert_true(down > 0.47 * scattered && down < 0.53 * scattered);
    assert_true(sky_irradiance(white, 2) > 1.6 * down && sky_irradiance(white, 2) < 2.6 * down);
    assert_true(pixel(black, 5, 40, 2) == 0);
    /* The thinner red sky scatters less, and less often. */
    assert_true(sky_irradiance(black, 0) < 0.3 * down);
    ty_image_destroy(black);
    ty_image_destroy(white);
}

static void the_ground_reflects_the_sky(void** state) {
    ty_context* context = *state;
    float sun[3];
    ty_sky_def def = sun_at(35, 10, TY_AXIS_Y);
    def.ground[0] = 0.1f, def.ground[1] = 0.4f, def.ground[2] = 0.8f;
    ty_image* image = make_sky(context, &def, sun);
    for (int c = 0; c < 3; ++c) {
        const double lit =
            (double)def.ground[c] / pi * ((double)sun[c] * sin(35 * pi / 180) + sky_irradiance(image, c));
        for (int32_t y = 32; y < 64; ++y)
            for (int32_t x = 0; x < 128; ++x) assert_true(fabs(pixel(image, x, y, c) / lit - 1) < 2e-3);
    }
    ty_image_destroy(image);
}

static void solar_scales_and_haze_dims(void** state) {
    skip_under_sanitizers();
    ty_context* context = *state;
    float once[3], twice[3], hazy[3];
    ty_sky_def def = sun_at(35, 10, TY_AXIS_Y);
    ty_image* a = make_sky(context, &def, once);
    for (int c = 0; c < 3; ++c) def.solar[c] *= 2;
    ty_image* b = make_sky(context, &def, twice);
    def.haze = 5;
    ty_image* d = make_sky(context, &def, hazy);
    for (int c = 0; c < 3; ++c) {
        assert_true(fabsf(twice[c] / once[c] - 2) < 1e-5f);
        assert_true(hazy[c] < 0.99f * twice[c]);
        for (int32_t i = 0; i < 128 * 64; ++i)
            assert_true(fabsf(ty_image_plane(b, c)[i] / ty_image_plane(a, c)[i] - 2) < 1e-5f);
    }
    /* Haze scatters forwards: a brighter aureole (the sun is near column 67, row 19). */
    assert_true(brightness(d, 67, 19) > 1.5 * brightness(b, 67, 19));
    ty_image_destroy(a);
    ty_image_destroy(b);
    ty_image_destroy(d);
}

static void refuse(ty_context* context, const ty_sky_def* def, const char* word) {
    ty_image* image = NULL;
    float sun[3];
    ty_take_error(context);
    assert_int_equal(ty_sky_create_image(context, def, &image, sun), TY_ERROR_ARGUMENT);
    assert_null(image);
    assert_non_null(strstr(ty_take_error(context), word));
}

static void arguments_are_checked(void** state) {
    ty_context* context = *state;
    const ty_sky_def good = ty_default_sky_def();
    ty_sky_def def;
    assert_int_equal(ty_sky_create_image(context, &good, NULL, NULL), TY_ERROR_ARGUMENT);
    refuse(context, NULL, "ty_default_sky_def");
    memset(&def, 0, sizeof def);
    refuse(context, &def, "ty_default_sky_def");
    def = good, memset(def.sun_direction, 0, sizeof def.sun_direction), refuse(context, &def, "sun_direction");
    def = good, def.sun_direction[1] = NAN, refuse(context, &def, "sun_direction");
    def = good, def.solar[2] = -1, refuse(context, &def, "solar[2]");
    def = good, def.solar[0] = INFINITY, refuse(context, &def, "solar[0]");
    def = good, def.ground[1] = 1.1f, refuse(context, &def, "ground[1]");
    def = good, def.haze = 10.5, refuse(context, &def, "haze");
    def = good, def.haze = NAN, refuse(context, &def, "haze");
    def = good, def.up_axis = (ty_axis)0, refuse(context, &def, "up_axis");
    def = good, def.ozone = -1, refuse(context, &def, "ozone");
    def = good, def.height = 1, refuse(context, &def, "height");
    def = good, def.height = 10001, refuse(context, &def, "height");
    def = good, def.scattering = (ty_sky_scattering)3, refuse(context, &def, "scattering");
    def = good, def.width = 17, refuse(context, &def, "width");
    def = good, def.width = 14, refuse(context, &def, "width");
    def = good, def.width = 8194, refuse(context, &def, "width");
}

static int release_table(void** state) {
    ty_sky_table_release(*state, &kept_table);
    return stop_context(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(kept_tables_do_not_matter),
        cmocka_unit_test(radiance_is_finite_everywhere),
        cmocka_unit_test(the_sky_is_brightest_around_the_sun),
        cmocka_unit_test(up_axes_agree),
        cmocka_unit_test(the_sky_is_symmetric_about_the_sun),
        cmocka_unit_test(colours_are_those_of_the_day),
        cmocka_unit_test(the_sun_has_its_irradiance),
        cmocka_unit_test(light_adds_up),
        cmocka_unit_test(the_ground_reflects_the_sky),
        cmocka_unit_test(solar_scales_and_haze_dims),
        cmocka_unit_test(arguments_are_checked),
    };
    return cmocka_run_group_tests(tests, start_context, release_table);
}
