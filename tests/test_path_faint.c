/* Samples that path spreads by what they are worth: more rays at outlines of lamps, and seldom a look at the sky from
 * deep within a medium. Neither changes the mean. */
#include "fog.h"

#include "base/context.h"
#include "method/path/driver.h"

/* Sums over channels and pixels, and the variances of both. */
typedef struct estimate {
    double mean, variance;
} estimate;

static void begin_run(const ty_scene* scene, ty_path_def* def, ty_path_run* run) {
    assert_int_equal(ty_path_prepare(scene, def, run), TY_OK);
    const ty_camera_def camera = ty_scene_camera(scene);
    run->request.kind = TY_PATH_PIXELS;
    run->request.width = run->request.crop[2] = WIDTH;
    run->height = run->request.crop[3] = HEIGHT;
    run->request.camera = ty_camera_get_view(&camera, WIDTH, HEIGHT);
    run->item_count = PIXELS;
    assert_int_equal(ty_path_run_begin(run, scene, false), TY_OK);
}

/* The mean over pixels, and its variance by the samples. */
static estimate sample_run(ty_path_run* run, uint64_t seed) {
    estimate out = {0, 0};
    run->request.seed = seed;
    memset(run->items, 0, PIXELS * sizeof *run->items);
    run->stats = ty_default_path_stats();
    assert_int_equal(ty_path_sample(run), TY_OK);
    for (int i = 0; i < PIXELS; ++i) {
        out.mean += ty_path_item_mean(&run->items[i], 1) / PIXELS;
        out.variance += ty_path_item_variance(&run->items[i], 1) / PIXELS / PIXELS;
    }
    return out;
}

/* A ball of 0.6 pixels that glows in thin fog. */
static ty_scene* lamp_scene(ty_context* context) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    const ty_medium_def fog = box_medium(lower, upper, 0.2f, 0.02f);
    ty_shape_def lamp = ty_default_shape_def();
    lamp.kind = TY_SHAPE_SPHERE;
    set3(lamp.origin, 0.1, 0.05, 0);
    lamp.radius = 0.15;
    set3f(lamp.emission, 3, 2, 1);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &lamp), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static void outlines_have_less_noise_and_the_same_mean(void** state) {
    ty_scene* scene = lamp_scene(*state);
    ty_path_def def = ty_default_path_def();
    ty_path_run run;
    def.spp = 512;
    begin_run(scene, &def, &run);
    int found = 0;
    assert_non_null(run.outlines);
    const estimate with = sample_run(&run, 1);
    for (int i = 0; i < PIXELS; ++i) found += run.outlines[i];
    assert_in_range(found, 1, 9);
    run.request.outlines = NULL;
    const estimate without = sample_run(&run, 2);
    /* Measured: 0.03 of the variance. */
    print_message("variance of outlines, with over without rays of their own: %.3f; mean %.4f, %.4f\n",
                  with.variance / without.variance, with.mean, without.mean);
    assert_true(with.variance < 0.1 * without.variance);
    assert_close((with.mean - without.mean) / sqrt(with.variance + without.variance), 0, 4);
    ty_path_run_end(&run);
    ty_scene_destroy(scene);
}

/* Pixels without emitters have no outlines. */
static void scenes_without_lamps_have_none(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = ty_default_path_def();
    ty_path_run run;
    begin_run(scene, &def, &run);
    assert_null(run.outlines);
    ty_path_run_end(&run);
    ty_scene_destroy(scene);
}

/* A cube of 40 mean free paths in all, with colour, under a sky that is brighter above. */
static void deep_media_keep_their_mean(void** state) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(*state);
    ty_medium_def cloud = box_medium(lower, upper, 20, 0.05f);
    set3f(cloud.g, 0.7f, 0.7f, 0.7f);
    set3f(cloud.sigma_a, 0.02f, 0.05f, 0.4f);
    const ty_light_def sky = sky_light(1, 2, 3);
    ty_light_def sun = ty_default_light_def();
    set3(sun.direction, -1, -2, -0.5);
    assert_int_equal(ty_scene_add_medium(scene, &cloud), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_path_def def = ty_default_path_def();
    ty_path_run run;
    def.spp = 64;
    begin_run(scene, &def, &run);
    assert_int_equal(run.request.deep, 1);
    const estimate by_chance = sample_run(&run, 1);
    run.request.deep = 0;
    const estimate always = sample_run(&run, 2);
    /* Measured: 0.9 of the variance, that is the same within its noise. */
    print_message("variance in deep media, by chance over always: %.3f; mean %.4f, %.4f\n",
                  by_chance.variance / always.variance, by_chance.mean, always.mean);
    assert_true(by_chance.variance < 1.2 * always.variance);
    assert_close((by_chance.mean - always.mean) / sqrt(by_chance.variance + always.variance), 0, 4);
    ty_path_run_end(&run);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(outlines_have_less_noise_and_the_same_mean),
        cmocka_unit_test(scenes_without_lamps_have_none),
        cmocka_unit_test(deep_media_keep_their_mean),
    };
    return cmocka_run_group_tests_name("path faint", tests, start_context, stop_context);
}
