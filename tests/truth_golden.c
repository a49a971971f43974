/* Path tracing against stored images of itself with many more samples, by a test of significance instead of a
 * tolerance.
 *
 * tests/golden holds means and variances of the means at 16384 samples a pixel (made by tests/golden/make.sh). Each
 * scene is rendered with fewer samples of another seed. Under the hypothesis that both images have the same expected
 * value, z = (a - b) / sqrt(var a + var b) of each pixel and channel is nearly normal. At least 99.75 % of the pixels
 * must have a two-sided p-value above the significance level of 1 % with Sidak's correction for the number of pixels,
 * and the weighted sum of z over the pixels of each channel must have one above that level with the correction for the
 * number of sums: pixels alone cannot see a change of 2 %, sums can. The same images with lights that are 2 % brighter
 * or darker must fail. */
#include "truth.h"

enum { SIDE = 16, PIXELS = SIDE * SIDE, CHANNELS = 3, STORED_SPP = 16384 };

static const double significance = 0.01, passing = 0.9975;

/* So many samples that lights 2 % brighter move the sums by five standard deviations or more. */
typedef struct stored_scene {
    const char* name;
    int32_t spp;
} stored_scene;

static const stored_scene scenes[] = {{"cube_g0.7", 4096}, {"cornell_fog", 4096}, {"fog_cornell", 8192},
                                      {"nebulae", 2048},   {"lamps", 2048},       {"cloud_sky", 512}};

enum { SCENES = sizeof scenes / sizeof *scenes };

/* The level of each of `tests` independent tests that makes their common one `significance` (Sidak 1967). */
static double sidak(int tests) {
    return 1 - pow(1 - significance, 1.0 / tests);
}

/* The two-sided p-value of a normal deviate. */
static double p_value(double z) {
    return erfc(fabs(z) / sqrt(2));
}

typedef struct verdict {
    double passed;             /* fraction of pixels and channels */
    double least;              /* p-value of any of them */
    double channels[CHANNELS]; /* p-values of the weighted sums of z over a channel's pixels */
    bool same;                 /* whether both images can have the same expected values */
} verdict;

/* The sums are Stouffer's (1949) with weights in proportion to the z that a change of brightness makes of a pixel, up
 * to a bound: pixels of nothing but sky are all but exact, and would leave the others no say. */
static const double most_weight = 100;

/* The image's own variance, or that of the stored one scaled to as many samples, whichever is larger: where light comes
 * by rare paths, few samples find too little of both. */
static verdict judge(const ty_image* image, const ty_image* stored, int32_t spp) {
    const double spp_ratio = (double)STORED_SPP / spp;
    verdict v = {0, 1, {0}, false};
    const double level = sidak(PIXELS * CHANNELS);
    int passed = 0;
    bool channels = true;
    for (int c = 0; c < CHANNELS; ++c) {
        static const char* const names[CHANNELS][2] = {{"R", "variance.R"}, {"G", "variance.G"}, {"B", "variance.B"}};
        const float* a = ty_image_plane_const(image, ty_image_find_channel(image, names[c][0]));
        const float* b = ty_image_plane_const(stored, ty_image_find_channel(stored, names[c][0]));
        const float* var_a = ty_image_plane_const(image, ty_image_find_channel(image, names[c][1]));
        const float* var_b = ty_image_plane_const(stored, ty_image_find_channel(stored, names[c][1]));
        double sum = 0, square = 0;
        for (int i = 0; i < PIXELS; ++i) {
            const double own = fmax((double)var_a[i], spp_ratio * (double)var_b[i]);
            const double rounding = 1e-6 * (double)b[i]; /* of single precision */
            const double z = ((double)a[i] - (double)b[i]) / sqrt(own + (double)var_b[i] + rounding * rounding + 1e-60);
            const double p = p_value(z);
            v.least = fmin(v.least, p);
            passed += p > level;
            const double weight = fmin((double)b[i] / sqrt(spp_ratio * (double)var_b[i] + 1e-60), most_weight);
            sum += weight * z;
            square += weight * weight;
        }
        v.channels[c] = p_value(sum / sqrt(square));
        channels = channels && v.channels[c] > sidak(CHANNELS * SCENES);
    }
    v.passed = (double)passed / (PIXELS * CHANNELS);
    v.same = channels && v.passed >= passing;
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

static ty_image* render_scene(ty_context* context, const stored_scene* s) {
    char path[64];
    ty_scene* scene = NULL;
    snprintf(path, sizeof path, "builtin:%s", s->name);
    must(context, ty_scene_load(context, path, NULL, 0, &scene));
    ty_image* image = render(scene, SIDE, s->spp, 1);
    ty_scene_destroy(scene);
    return image;
}

/* Makes all lights of an image `factor` times as bright: path tracing is linear in them. */
static void scale_lights(ty_image* image, double factor) {
    for (int c = 0; c < CHANNELS; ++c)
        for (int i = 0; i < PIXELS; ++i) {
            ty_image_plane(image, c)[i] *= (float)factor;
            ty_image_plane(image, c + CHANNELS)[i] *= (float)(factor * factor);
        }
}

static verdict judge_and_print(const ty_image* image, const ty_image* stored, const stored_scene* s, const char* what) {
    const verdict v = judge(image, stored, s->spp);
    printf("%-12s %-14s %.4f of the pixels pass, least p %.2g; p of the channels %.3g %.3g %.3g\n", s->name, what,
           v.passed, v.least, v.channels[0], v.channels[1], v.channels[2]);
    return v;
}

static void images_have_the_stored_means_and_no_others(void** state) {
    bool same = true, found = true;
    for (int i = 0; i < SCENES; ++i) {
        ty_image *stored = read_stored(*state, scenes[i].name), *image = render_scene(*state, &scenes[i]);
        same = judge_and_print(image, stored, &scenes[i], "as it is").same && same;
        scale_lights(image, 1.02);
        found = !judge_and_print(image, stored, &scenes[i], "lights x 1.02").same && found;
        scale_lights(image, 0.98 / 1.02);
        found = !judge_and_print(image, stored, &scenes[i], "lights x 0.98").same && found;
        ty_image_destroy(stored);
        ty_image_destroy(image);
    }
    assert_true(same);
    assert_true(found);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(images_have_the_stored_means_and_no_others)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
