/* Light that lamps scatter into rays: the mean of an image of a ball of fog with a lamp in its center, whatever the
 * seed, and its energy. */
#include "truth.h"

enum { SIDE = 32, SEEDS = 16, SEEDS_QUICK = 4 };

static const double radius = 2.5, intensity = 10; /* m, W/sr */

/* A camera 9 m from a ball of radius 2.5 m and sigma_s 1/m with a point light of 10 W/sr in its center. */
static ty_scene* lamp_in_ball(ty_context* context, double g) {
    ty_scene* scene = new_scene(context);
    const ty_medium_def fog = medium_sphere(radius, 1, 0, g);
    const ty_light_def lamp = light_of(TY_LIGHT_POINT, intensity);
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

static seed_spread spread_over_seeds(ty_context* context, const ty_scene* scene, bool point_light_directions, int seeds,
                                     int32_t spp) {
    double sum = 0, square = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
        ty_path_def def = ty_default_path_def();
        ty_image* image = NULL;
        def.width = def.height = SIDE;
        def.spp = spp;
        def.seed = (uint64_t)seed;
        def.point_light_directions = point_light_directions;
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
    static const double cosines[] = {0.5, 0.7, 0.9, 0.96};
    static const double allowed[] = {0.012, 0.012, 0.03, 0.08}; /* of 512 samples per pixel of 32 x 32 */
    const int seeds = in_full() ? SEEDS : SEEDS_QUICK;
    for (int i = in_full() ? 0 : 1; i < (in_full() ? 4 : 2); ++i) {
        ty_scene* scene = lamp_in_ball(*state, cosines[i]);
        const seed_spread with = spread_over_seeds(*state, scene, true, seeds, 512);
        printf("lamp in a ball, g %.2f: mean %.5f, seeds within %.2f%%\n", cosines[i], with.mean, 100 * with.deviation);
        if (!(with.deviation < allowed[i]))
            fail_msg("g %g: image means of seeds deviate by %g", cosines[i], with.deviation);
        const seed_spread without = spread_over_seeds(*state, scene, false, seeds, 512);
        ty_scene_destroy(scene);
        printf("  without lamp directions: mean %.5f, seeds within %.2f%%\n", without.mean, 100 * without.deviation);
        const double noise =
            4 * sqrt((with.deviation * with.deviation + without.deviation * without.deviation) / seeds);
        if (!(fabs(without.mean / with.mean - 1) < noise + 0.02))
            fail_msg("g %g: means %g and %g", cosines[i], with.mean, without.mean);
    }
}

/* Nothing absorbs: the light that the fog scattered leaves the ball through any sphere about it. With L the radiance of
 * a ray that passes the center at distance b, the power is 4 pi^2 integral of L d(b^2), whatever the sphere's radius.
 */
static void scattered_light_leaves_the_ball(void** state) {
    static const double cosines[] = {0, 0.5, 0.7, 0.9, 0.96};
    enum { RAYS = 512 };
    for (int i = in_full() ? 0 : 4; i < 5; ++i) {
        double rays[RAYS][6], radiance[RAYS][3], variances[RAYS][3], sum = 0, variance = 0;
        for (int k = 0; k < RAYS; ++k) {
            const double b = radius * (k + 0.5) / RAYS;
            memcpy(rays[k], (const double[]){b, 0, 9, 0, 0, 1}, sizeof rays[k]);
        }
        ty_scene* scene = lamp_in_ball(*state, cosines[i]);
        ty_path_def def = ty_default_path_def();
        def.spp = fewer(32768, 64) * (cosines[i] > 0.8 ? 4 : 1);
        must(*state, ty_path_radiance(scene, &def, &rays[0][0], RAYS, &radiance[0][0], &variances[0][0]));
        ty_scene_destroy(scene);
        for (int k = 0; k < RAYS; ++k) {
            const double share = 2 * (k + 0.5) / ((double)RAYS * RAYS); /* of d(b^2) */
            sum += share * radiance[k][1];
            variance += share * share * variances[k][1];
        }
        const double expected = intensity * (1 - exp(-radius)) / (pi * radius * radius);
        printf("lamp in a ball, g %.2f: scattered light that leaves it over the lamp's %.4f +- %.4f\n", cosines[i],
               sum / expected, sqrt(variance) / expected);
        if (!(fabs(sum / expected - 1) < 0.01 + (in_full() ? 0 : 3 * sqrt(variance) / expected)))
            fail_msg("g %g: %g of the scattered light leaves", cosines[i], sum / expected);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(scattered_light_leaves_the_ball),
                                       cmocka_unit_test(image_means_hold_for_every_seed)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
