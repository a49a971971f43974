/* Black bodies against published colours and luminances, and the kernels' table against the exact radiance. */
#include "checks.h"
#include "scene/media/blackbody.h"

static ty_blackbody_table table;

static int fill_table(void** state) {
    (void)state;
    ty_blackbody_fill(&table);
    return 0;
}

static double luminance(const float rgb[3]) {
    return 0.212639 * (double)rgb[0] + 0.715169 * (double)rgb[1] + 0.072192 * (double)rgb[2];
}

static double luminance_at(double kelvin) {
    float rgb[3];
    ty_blackbody(kelvin, rgb);
    return luminance(rgb);
}

static void assert_chromaticity(const float rgb[3], double x, double y, double tolerance) {
    const double r = (double)rgb[0], g = (double)rgb[1], b = (double)rgb[2];
    const double cie_x = 0.412391 * r + 0.357584 * g + 0.180481 * b;
    const double cie_z = 0.019331 * r + 0.119195 * g + 0.950532 * b;
    const double sum = cie_x + luminance(rgb) + cie_z;
    assert_close(cie_x / sum, x, tolerance);
    assert_close(luminance(rgb) / sum, y, tolerance);
}

/* The Planckian locus where it is within Rec.709; 2856 K is the CIE's illuminant A. */
static void colours_are_the_published_ones(void** state) {
    (void)state;
    static const double locus[][3] = {{2000, 0.5267, 0.4133},  {2856, 0.4476, 0.4074},  {4000, 0.3805, 0.3768},
                                      {6504, 0.3135, 0.3236},  {10000, 0.2807, 0.2884}, {20000, 0.2565, 0.2577},
                                      {100000, 0.2426, 0.2381}};
    for (size_t i = 0; i < sizeof locus / sizeof *locus; ++i) {
        float rgb[3];
        ty_blackbody(locus[i][0], rgb);
        assert_chromaticity(rgb, locus[i][1], locus[i][2], 1e-4);
    }
}

/* Until 1979 the candela was 1/60 of what a square centimetre of freezing platinum sends. By Stefan's law the efficacy
 * of a black body is 54.7 lm/W at 4000 K, and nowhere higher than the 95 lm/W near 6600 K. */
static void luminances_are_the_published_ones(void** state) {
    (void)state;
    assert_close(683 * luminance_at(2042) / 60e4, 1, 0.004);
    const double stefan = 5.670374419e-8, pi = 3.14159265358979;
    assert_close(683 * luminance_at(4000) * pi / (stefan * pow(4000, 4)), 54.7, 0.1);
    double best = 0, hottest = 0;
    for (double kelvin = 3000; kelvin < 15000; kelvin += 20) {
        const double efficacy = 683 * luminance_at(kelvin) * pi / (stefan * pow(kelvin, 4));
        if (efficacy <= best) continue;
        best = efficacy;
        hottest = kelvin;
    }
    assert_close(best, 95.4, 0.5);
    assert_close(hottest, 6620, 100);
}

/* Luminance grows as Wien's law says for yellow light when it is dark red to white, and as T when it is blue. */
static void growth_is_planck_s(void** state) {
    (void)state;
    const double wavelength = 1.438777e-2 * (1 / 2000.0 - 1 / 2010.0) / log(luminance_at(2010) / luminance_at(2000));
    assert_true(wavelength > 570e-9 && wavelength < 610e-9);
    assert_close(luminance_at(100000) / luminance_at(50000), 2.3, 0.1);
    float last[3] = {0, 0, 0};
    for (double kelvin = 210; kelvin < 100000; kelvin *= 1.01) {
        float rgb[3];
        ty_blackbody(kelvin, rgb);
        assert_true(rgb[0] > last[0] && rgb[1] >= last[1] && rgb[2] >= last[2]);
        assert_true(kelvin < 2000 || (rgb[1] > last[1] && rgb[2] > last[2]));
        memcpy(last, rgb, sizeof last);
    }
}

static void ends_are_as_promised(void** state) {
    (void)state;
    float rgb[3] = {1, 1, 1}, hottest[3];
    static const double none[] = {199.9, 0, -5, -INFINITY, NAN};
    for (size_t i = 0; i < sizeof none / sizeof *none; ++i) {
        rgb[0] = 1;
        ty_blackbody(none[i], rgb);
        assert_true(rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0);
        rgb[0] = 1;
        ty_blackbody_lookup(&table, (float)none[i], rgb);
        assert_true(rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0);
    }
    ty_blackbody(100000, hottest);
    static const double beyond[] = {100001, 1e30, INFINITY};
    for (size_t i = 0; i < sizeof beyond / sizeof *beyond; ++i) {
        ty_blackbody(beyond[i], rgb);
        assert_memory_equal(rgb, hottest, sizeof rgb);
        ty_blackbody_lookup(&table, (float)beyond[i], rgb);
        for (int c = 0; c < 3; ++c) assert_close((double)rgb[c] / (double)hottest[c], 1, 1e-4);
    }
}

static void the_table_is_close(void** state) {
    (void)state;
    for (double kelvin = 250; kelvin < 100000; kelvin *= 1.00037) {
        float exact[3], found[3];
        const float narrow = (float)kelvin;
        ty_blackbody((double)narrow, exact);
        ty_blackbody_lookup(&table, narrow, found);
        const double most = fmax((double)exact[0], fmax((double)exact[1], (double)exact[2]));
        for (int c = 0; c < 3; ++c)
            assert_close((double)found[c], (double)exact[c], most * (kelvin < 800 ? 5e-4 : 1e-4));
    }
}

static void white_is_white(void** state) {
    (void)state;
    static const float d65[3] = {0.95045593f, 1, 1.08905775f}, equal[3] = {1, 1, 1}, red[3] = {0.735f, 0.265f, 0};
    float rgb[3];
    ty_rgb_from_xyz(d65, rgb);
    for (int c = 0; c < 3; ++c) assert_close(rgb[c], 1, 1e-5);
    ty_rgb_from_xyz(equal, rgb);
    assert_chromaticity(rgb, 1.0 / 3, 1.0 / 3, 1e-5);
    ty_rgb_from_xyz(red, rgb);
    assert_true(rgb[0] > 1 && rgb[1] == 0 && rgb[2] == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours_are_the_published_ones),
        cmocka_unit_test(luminances_are_the_published_ones),
        cmocka_unit_test(growth_is_planck_s),
        cmocka_unit_test(ends_are_as_promised),
        cmocka_unit_test(the_table_is_close),
        cmocka_unit_test(white_is_white),
    };
    return cmocka_run_group_tests(tests, fill_table, NULL);
}
