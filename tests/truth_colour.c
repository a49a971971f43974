/* A coloured medium is three gray ones: channel by channel the same picture, and not much noisier. */
#include "truth.h"

enum { SIDE = 64, SPP = 96 };

typedef struct coefficients {
    double sigma_s[3], sigma_a[3], g[3];
} coefficients;

static const coefficients mild = {{3, 5, 8}, {0.5, 0.2, 0.05}, {0.2, 0.5, 0.75}};
static const coefficients harsh = {{0.2, 4, 30}, {2, 0, 0.5}, {0.9, 0, -0.6}};

/* A ball or a cloud in sun and sky, of the medium's colours, or gray as one of its channels. */
static ty_image* picture(ty_context* context, const coefficients* of, int channel, bool cloud, uint64_t seed) {
    ty_scene* scene = new_scene(context);
    ty_medium_def medium = cloud ? medium_cube(0.6, 0, 0, 0) : medium_sphere(0.6, 0, 0, 0);
    for (int c = 0; c < 3; ++c) {
        const int from = channel < 0 ? c : channel;
        medium.sigma_s[c] = (float)of->sigma_s[from];
        medium.sigma_a[c] = (float)of->sigma_a[from];
        medium.g[c] = (float)of->g[from];
    }
    ty_noise_def noise = ty_default_noise_def();
    noise.size[0] = noise.size[1] = noise.size[2] = 32;
    if (cloud) must(context, ty_grid_create_noise(context, &noise, &medium.density_grid));
    add_medium(scene, &medium);
    ty_grid_release(medium.density_grid);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 2), sky = light_of(TY_LIGHT_ENVIRONMENT, 0.3);
    set3(sun.direction, -1, -1, -0.3);
    add_light(scene, &sun);
    add_light(scene, &sky);
    set_camera(scene, 1, 0.5, 4, 18);
    commit(scene);
    ty_image* image = render(scene, SIDE, SPP, seed);
    assert_finite(image);
    ty_scene_destroy(scene);
    return image;
}

/* The mean square of single samples, and the part of it that is their variance, where the medium is seen. */
typedef struct spread {
    double square, variance;
} spread;

static spread samples_of(const ty_image* image, int channel) {
    spread sum = {0, 0};
    int seen = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const double value = (double)ty_image_plane_const(image, channel)[i];
        const double variance = SPP * (double)ty_image_plane_const(image, channel + 3)[i];
        if (variance <= 1e-9 * value * value) continue;
        sum.variance += variance;
        sum.square += value * value + variance;
        ++seen;
    }
    return (spread){sum.square / seen, sum.variance / seen};
}

/* Paths that carry one colour each, chosen by chance, would have three times the mean square of gray paths: that is
 * what sharing them must not exceed by much. (Their variance alone may be many times that of a gray estimate that
 * hardly varies.) */
static void check(ty_context* context, const char* name, const coefficients* of, bool cloud) {
    ty_image* image = picture(context, of, -1, cloud, 1);
    for (int c = 0; c < 3; ++c) {
        ty_image* alone = picture(context, of, c, cloud, 2 + (uint64_t)c);
        const spread shared = samples_of(image, c), own = samples_of(alone, 0);
        printf("%-36s %c: samples' mean square %.2f times that of gray, of 4; variance %.2f times\n", name, "RGB"[c],
               shared.square / own.square, shared.variance / own.variance);
        assert_same_channel(name, image, c, alone, 0, 0.005);
        if (!(shared.square <= 4 * own.square)) fail_msg("%s: colour noise", name);
        ty_image_destroy(alone);
    }
    ty_image_destroy(image);
}

static void a_coloured_ball_is_unbiased(void** state) {
    leave_to_full_runs();
    check(*state, "ball", &mild, false);
}

static void a_coloured_cloud_is_unbiased(void** state) {
    leave_to_full_runs();
    check(*state, "cloud", &mild, true);
}

static void a_ball_of_harsh_colours_is_unbiased(void** state) {
    check(*state, "ball, harsh colours", &harsh, false);
}

static void a_cloud_of_harsh_colours_is_unbiased(void** state) {
    check(*state, "cloud, harsh colours", &harsh, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_coloured_ball_is_unbiased),
        cmocka_unit_test(a_coloured_cloud_is_unbiased),
        cmocka_unit_test(a_ball_of_harsh_colours_is_unbiased),
        cmocka_unit_test(a_cloud_of_harsh_colours_is_unbiased),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
