/* Rooms and courts lit by area lights, emissive surfaces and the sky: method lpv against path tracing, over blocks of
 * pixels, at most a tenth off in the mean. */
#include "truth_scene.h"

/* Mean ratio and relative RMSE, with path tracing's noise in them. */
typedef struct nearness {
    double ratio, rmse;
} nearness;

/* As measured; mean ratios are held to ratio_margin, RMSEs to 1 + rmse_margin times these. */
static const nearness box_measured = {1.022, 0.184}, hall_measured = {0.945, 0.095}, court_measured = {0.988, 0.051};
static const double ratio_margin = 0.02, rmse_margin = 0.15;

static void check_scene(ty_context* context, const scene_case* c, const nearness* expected) {
    ty_scene* scene = read_case(context, c);
    ty_image *truth = path_image(scene, c, 0), *image = NULL;
    ty_lpv_def def = ty_default_lpv_def();
    double sum = 0, true_sum = 0, square = 0;
    int count = 0;
    def.width = c->width;
    def.height = c->height;
    def.spp = 4;
    must(context, ty_lpv_render(scene, &def, &image, NULL));
    assert_finite(image);
    for (int y = 0; y + BLOCK <= c->height; y += BLOCK)
        for (int x = 0; x + BLOCK <= c->width; x += BLOCK, ++count) {
            const double own = block_light(image, x, y), right = block_light(truth, x, y);
            sum += own;
            true_sum += right;
            square += (own - right) * (own - right);
        }
    const nearness near = {sum / true_sum, sqrt(square * count) / true_sum};
    printf("%s: mean ratio %.4f, relative RMSE %.4f\n", c->path, near.ratio, near.rmse);
    ty_image_destroy(image);
    ty_image_destroy(truth);
    ty_scene_destroy(scene);
    assert_true(fabs(near.ratio - expected->ratio) <= ratio_margin && fabs(near.ratio - 1) <= 0.1);
    assert_true(near.rmse <= (1 + rmse_margin) * expected->rmse && near.rmse <= 0.25);
}

static void box_under_an_area_light(void** state) {
    const scene_case c = {"builtin:cornell_fog", NULL, {NULL}, 48, 48, 96, 0, 0, 0};
    check_scene(*state, &c, &box_measured);
}

static void hall_of_emissive_boxes(void** state) {
    const scene_case c = {TYNDALL_SOURCE_DIR "/scenes/tools/path_hall.json", NULL, {NULL}, 60, 42, 40, 0, 0, 0};
    check_scene(*state, &c, &hall_measured);
}

static void court_under_the_sky(void** state) {
    const scene_case c = {TYNDALL_SOURCE_DIR "/scenes/tools/lpv_court.json", NULL, {NULL}, 60, 48, 64, 0, 0, 0};
    check_scene(*state, &c, &court_measured);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_under_an_area_light),
        cmocka_unit_test(hall_of_emissive_boxes),
        cmocka_unit_test(court_under_the_sky),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
