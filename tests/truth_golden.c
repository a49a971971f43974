/* Path tracing against stored images of itself with many more samples, by a test of significance instead of a
 * tolerance.
 *
 * tests/golden holds means and variances of the means at 16384 samples a pixel (made by tests/golden/make.sh). Each
 * scene is rendered with 256 samples of another seed. Under the hypothesis that both images have the same expected
 * value, z = (a - b) / sqrt(var a + var b) of each pixel and channel is nearly normal. At least 99.75 % of the pixels
 * must have a two-sided p-value above the significance level of 1 % with Sidak's correction for the number of pixels,
 * and so must the mean of each channel: pixels alone cannot see a change of 2 %, means can. That they do is tested,
 * too, with lights that are 2 % brighter. */
#include "truth.h"

enum { SIDE = 16, PIXELS = SIDE * SIDE, CHANNELS = 3, SPP = 256 };

static const double significance = 0.01, passing = 0.9975;

static const char* const scenes[] = {"cube_g0.7", "cornell_fog", "fog_cornell", "nebulae", "lamps", "cloud_sky"};

enum { SCENES = sizeof scenes / sizeof *scenes };

/* The level of each of `tests` independent tests that makes their common one `significance` (Sidak 1967). */
static double sidak(int tests) {
    return 1 - pow(1 - significance, 1.0 / tests);
}

/* The two-sided p-value of a difference with a variance. Rounding of single precision is part of the variance. */
static double p_value(double difference, double variance, double value) {
    const double rounding = 1e-6 * value, z = difference / sqrt(variance + rounding * rounding + 1e-60);
    return erfc(fabs(z) / sqrt(2));
}

typedef struct verdict {
    double passed;          /* fraction of pixels and channels */
    double least;           /* p-value of any of them */
    double means[CHANNELS]; /* p-values of the images' means */
    bool same;              /* whether both images can have the same expected value */
} verdict;

/* The image's own variance, or that of the stored one scaled to as many samples, whichever is larger: where light comes
 * by rare paths, few samples find too little of both. */
static verdict judge(const ty_image* image, const ty_image* stored, double spp_ratio) {
    verdict v = {0, 1, {0}, false};
    const double level = sidak(PIXELS * CHANNELS);
    int passed = 0;
    bool means = true;
    for (int c = 0; c < CHANNELS; ++c) {
        static const char* const names[CHANNELS][2] = {{"R", "variance.R"}, {"G", "variance.G"}, {"B", "variance.B"}};
        const float* a = ty_image_plane_const(image, ty_image_find_channel(image, names[c][0]));
        const float* b = ty_image_plane_const(stored, ty_image_find_channel(stored, names[c][0]));
        const float* var_a = ty_image_plane_const(image, ty_image_find_channel(image, names[c][1]));
        const float* var_b = ty_image_plane_const(stored, ty_image_find_channel(stored, names[c][1]));
        double difference = 0, variance = 0, sum = 0;
        for (int i = 0; i < PIXELS; ++i) {
            const double own = fmax((double)var_a[i], spp_ratio * (double)var_b[i]);
            const double p = p_value((double)a[i] - (double)b[i], own + (double)var_b[i], (double)b[i]);
            v.least = fmin(v.least, p);
            passed += p > level;
            difference += (double)a[i] - (double)b[i];
            variance += (double)var_a[i] + (double)var_b[i];
            sum += (double)b[i];
        }
        v.means[c] = p_value(difference, variance, sum);
        means = means && v.means[c] > sidak(CHANNELS * SCENES);
    }
    v.passed = (double)passed / (PIXELS * CHANNELS);
    v.same = means && v.passed >= passing;
    return v;
}

static ty_image* read_stored(ty_context* context, const char* name) {
    char path[512];
    ty_image* image = NULL;
    snprintf(path, sizeof path, "%s/tests/golden/%s.exr", TYNDALL_SOURCE_DIR, name);
    must(context, ty_image_read(context, path, &image));
    assert_int_equal(ty_image_width(image), SIDE);
    assert_int_equal(ty_image_height(image), SIDE);
    return image;
}

/* A scene's image with all of its lights' radiance times `brightness`. Path tracing is linear in it. */
static ty_image* render_scene(ty_context* context, const char* name, uint64_t seed, double brightness) {
    char path[64];
    ty_scene* scene = NULL;
    snprintf(path, sizeof path, "builtin:%s", name);
    must(context, ty_scene_load(context, path, NULL, 0, &scene));
    ty_image* image = render(scene, SIDE, SPP, seed);
    for (int c = 0; c < CHANNELS; ++c)
        for (int i = 0; i < PIXELS; ++i) {
            ty_image_plane(image, c)[i] *= (float)brightness;
            ty_image_plane(image, c + CHANNELS)[i] *= (float)(brightness * brightness);
        }
    ty_scene_destroy(scene);
    return image;
}

static void print_verdict(const char* name, const char* what, const verdict* v) {
    printf("%-12s %-14s %.4f of the pixels pass, least p %.2g; p of the means %.3g %.3g %.3g\n", name, what, v->passed,
           v->least, v->means[0], v->means[1], v->means[2]);
}

static const double spp_ratio = 16384.0 / SPP;

static void images_have_the_stored_means(void** state) {
    bool same = true;
    for (int i = 0; i < SCENES; ++i) {
        ty_image *stored = read_stored(*state, scenes[i]), *image = render_scene(*state, scenes[i], 1, 1);
        const verdict v = judge(image, stored, spp_ratio);
        print_verdict(scenes[i], "as it is", &v);
        same = same && v.same;
        ty_image_destroy(stored);
        ty_image_destroy(image);
    }
    assert_true(same);
}

static void lights_of_another_brightness_are_found(void** state) {
    static const double brightness[] = {0.98, 1.02};
    bool found = true;
    for (int i = 0; i < SCENES; ++i)
        for (int k = 0; k < 2; ++k) {
            ty_image* stored = read_stored(*state, scenes[i]);
            ty_image* image = render_scene(*state, scenes[i], 1, brightness[k]);
            const verdict v = judge(image, stored, spp_ratio);
            print_verdict(scenes[i], k == 0 ? "lights x 0.98" : "lights x 1.02", &v);
            found = found && !v.same;
            ty_image_destroy(stored);
            ty_image_destroy(image);
        }
    assert_true(found);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(images_have_the_stored_means),
                                       cmocka_unit_test(lights_of_another_brightness_are_found)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
