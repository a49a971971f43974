/* The error that path tracing reports, against the errors of images of several seeds: lamps in media, whose samples
 * have heavy tails. */
#include "truth.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE, VALUES = 3 * PIXELS, SEEDS_MOST = 16, SEEDS_QUICK = 6 };

static ty_light_def lamp_at(double x, double intensity) {
    ty_light_def def = light_of(TY_LIGHT_POINT, intensity);
    def.position[0] = x;
    return def;
}

typedef enum lamp_scene { ONE_LAMP, NEAR_WALL, TWO_LAMPS, SPOT_IN_FOG } lamp_scene;

static ty_scene* make_scene(ty_context* context, lamp_scene kind, double g) {
    ty_scene* scene = NULL;
    if (kind == SPOT_IN_FOG) {
        must(context, ty_scene_load(context, "builtin:fog_cornell", NULL, 0, &scene));
        return scene;
    }
    scene = new_scene(context);
    const ty_medium_def fog = medium_sphere(2.5, 1, 0, g);
    add_medium(scene, &fog);
    if (kind == TWO_LAMPS) {
        const ty_light_def left = lamp_at(-1, 5), right = lamp_at(1, 5);
        add_light(scene, &left);
        add_light(scene, &right);
    } else {
        const ty_light_def lamp = lamp_at(0, 10);
        add_light(scene, &lamp);
    }
    if (kind == NEAR_WALL) {
        static const double center[3] = {0, 0, -0.1}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
        const ty_shape_def wall = square_shape(center, x, y, 1.5, 0.5);
        add_shape(scene, &wall);
    }
    set_camera(scene, 0, 0, 9, 36);
    commit(scene);
    return scene;
}

typedef struct error_case {
    const char* name;
    lamp_scene kind;
    double g;
} error_case;

static const error_case cases[] = {{"ball, g 0.7", ONE_LAMP, 0.7}, {"ball, g 0.96", ONE_LAMP, 0.96},
                                   {"ball, g 0.5", ONE_LAMP, 0.5}, {"ball, g 0.9", ONE_LAMP, 0.9},
                                   {"at a wall", NEAR_WALL, 0.7},  {"two lamps", TWO_LAMPS, 0.7},
                                   {"spot in fog", SPOT_IN_FOG, 0}};

typedef struct seed_images {
    ty_image* image[SEEDS_MOST];
    double reported[SEEDS_MOST], pixels[SEEDS_MOST], mean[VALUES];
    int count;
} seed_images;

static double value_of(const ty_image* image, int i) {
    return (double)ty_image_plane_const(image, i / PIXELS)[i % PIXELS];
}

static void render_seeds(ty_context* context, const ty_scene* scene, bool point_light_directions, seed_images* out) {
    memset(out, 0, sizeof *out);
    out->count = in_full() ? SEEDS_MOST : SEEDS_QUICK;
    for (int s = 0; s < out->count; ++s) {
        ty_path_def def = ty_default_path_def();
        ty_path_stats stats = ty_default_path_stats();
        def.width = def.height = SIDE;
        def.spp = fewer(128, 4);
        def.seed = (uint64_t)s + 1;
        def.point_light_directions = point_light_directions;
        must(context, ty_path_render(scene, &def, &out->image[s], &stats));
        out->reported[s] = stats.error;
        out->pixels[s] = stats.error_pixels;
        for (int i = 0; i < VALUES; ++i) out->mean[i] += value_of(out->image[s], i) / out->count;
    }
}

/* Root mean square of a seed's image off the mean of all images with lamp directions, over the image's own mean, as
 * path tracing reports it. The mean of images without lamp directions would be off by a fraction of the worst. */
static double true_error(const seed_images* seeds, int s, const seed_images* with) {
    /* The image is a part of the mean. */
    const double own_part = seeds == with ? (double)with->count / (with->count - 1) : 1;
    double sum = 0, own_mean = 0;
    for (int i = 0; i < VALUES; ++i) {
        const double value = value_of(seeds->image[s], i);
        sum += pow(value - with->mean[i], 2);
        own_mean += value / VALUES;
    }
    return sqrt(sum / VALUES * own_part) / own_mean;
}

/* Every image's error is within a factor of two of what it reports; of three by equiangular sampling alone, where one
 * pixel makes most of it. Where it rests on many pixels, it is also that of the other seeds. */
static void check_errors(const error_case* c, const seed_images* seeds, const seed_images* with) {
    double least = 1e9, most = 0, square = 0, fewest = 1e9;
    for (int s = 0; s < seeds->count; ++s) {
        const double error = true_error(seeds, s, with), ratio = seeds->reported[s] / error;
        least = fmin(least, ratio);
        most = fmax(most, ratio);
        fewest = fmin(fewest, seeds->pixels[s]);
        square += error * error / seeds->count;
    }
    printf("%-12s %s lamp directions: error %.3f, reported over true %.2f to %.2f, by at least %.0f pixels\n", c->name,
           seeds == with ? "with   " : "without", sqrt(square), least, most, fewest);
    const double factor = seeds == with ? 2 : 3;
    if (!(least > 1 / factor && most < factor)) fail_msg("%s: reported over true from %g to %g", c->name, least, most);
    for (int s = 0; s < seeds->count; ++s) {
        const double ratio = seeds->reported[s] / sqrt(square);
        if (seeds->pixels[s] >= 10 && seeds == with && !(ratio > 0.5 && ratio < 2))
            fail_msg("%s: seed %d reports %g of the error of all", c->name, s + 1, ratio);
    }
}

static void drop_seeds(seed_images* seeds) {
    for (int s = 0; s < seeds->count; ++s) ty_image_destroy(seeds->image[s]);
}

static void reported_errors_are_those_of_images(void** state) {
    const int count = in_full() ? (int)(sizeof cases / sizeof *cases) : 2;
    static seed_images with, without;
    for (int i = 0; i < count; ++i) {
        ty_scene* scene = make_scene(*state, cases[i].kind, cases[i].g);
        render_seeds(*state, scene, true, &with);
        render_seeds(*state, scene, false, &without);
        ty_scene_destroy(scene);
        check_errors(&cases[i], &with, &with);
        check_errors(&cases[i], &without, &with);
        drop_seeds(&with);
        drop_seeds(&without);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(reported_errors_are_those_of_images)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
