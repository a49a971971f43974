/* Light that lamps scatter into rays: the mean of an image of a ball of fog with a lamp in its center, whatever the
 * seed. */
#include "truth.h"

enum { SIDE = 32, SEEDS = 16, SEEDS_QUICK = 4 };

/* A camera 9 m from a ball of radius 2.5 m and sigma_s 1/m with a point light of 10 W/sr in its center. */
static ty_scene* lamp_in_ball(ty_context* context, double g) {
    ty_scene* scene = new_scene(context);
    const ty_medium_def fog = medium_sphere(2.5, 1, 0, g);
    const ty_light_def lamp = light_of(TY_LIGHT_POINT, 10);
    add_medium(scene, &fog);
    add_light(scene, &lamp);
    set_camera(scene, 0, 0, 9, 36);
    commit(scene);
    return scene;
}

static double green_mean(const ty_image* image) {
    const float* plane = ty_image_plane_const(image, 1);
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) sum += (double)plane[i];
    return sum / (SIDE * SIDE);
}

typedef struct seed_spread {
    double mean, deviation; /* of image means; the deviation relative to the mean */
} seed_spread;

static seed_spread spread_over_seeds(ty_context* context, const ty_scene* scene, bool lamp_directions, int seeds,
                                     int32_t spp) {
    double sum = 0, square = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
        ty_path_def def = ty_default_path_def();
        ty_image* image = NULL;
        def.width = def.height = SIDE;
        def.spp = spp;
        def.seed = (uint64_t)seed;
        def.lamp_directions = lamp_directions;
        must(context, ty_path_render(scene, &def, &image, NULL));
        const double mean = green_mean(image);
        ty_image_destroy(image);
        sum += mean;
        square += mean * mean;
    }
    const double mean = sum / seeds;
    return (seed_spread){mean, sqrt(fmax(0, (square - seeds * mean * mean) / (seeds - 1))) / mean};
}

/* The spread over seeds is small, and lamp directions do not change the mean. */
static void image_means_hold_for_every_seed(void** state) {
    static const double cosines[] = {0.5, 0.7, 0.9};
    static const double allowed[] = {0.012, 0.012, 0.03}; /* of 512 samples per pixel of 32 x 32 */
    const int seeds = in_full() ? SEEDS : SEEDS_QUICK;
    for (int i = 0; i < 3; ++i) {
        ty_scene* scene = lamp_in_ball(*state, cosines[i]);
        const seed_spread with = spread_over_seeds(*state, scene, true, seeds, 512);
        const seed_spread without = spread_over_seeds(*state, scene, false, seeds, 512);
        ty_scene_destroy(scene);
        printf("lamp in a ball, g %.1f: mean %.5f, seeds within %.2f%% (without lamp directions %.5f, %.2f%%)\n",
               cosines[i], with.mean, 100 * with.deviation, without.mean, 100 * without.deviation);
        if (!(with.deviation < allowed[i]))
            fail_msg("g %g: image means of seeds deviate by %g", cosines[i], with.deviation);
        const double noise =
            4 * sqrt((with.deviation * with.deviation + without.deviation * without.deviation) / seeds);
        if (!(fabs(without.mean / with.mean - 1) < noise + 0.02))
            fail_msg("g %g: means %g and %g", cosines[i], with.mean, without.mean);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(image_means_hold_for_every_seed)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
