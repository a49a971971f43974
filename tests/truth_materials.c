/* Pictures of metal, plastic, glass, milk, water and maps of normals against those that two other renderers made of
 * them. */
#include "truth_cases.h"

/* True, with a line, if the references are absent. */
static bool has_reference(const char* name, char scene[1024], char image[1024]) {
    char file[128];
    snprintf(file, sizeof file, "reference/materials/%s.exr", name);
    data_path(file, image);
    snprintf(file, sizeof file, "reference/materials/%.*s.json", (int)strcspn(name, "."), name);
    data_path(file, scene);
    FILE* stream = fopen(image, "rb");
    if (stream == NULL) {
        print_message("there is no %s\n", image);
        return false;
    }
    fclose(stream);
    return true;
}

/* tolerance: of the mean; blocks: of 8x8 pixels, noise of ours and theirs included. */
static void check_material(ty_context* context, const char* name, bool compensated, double tolerance, double blocks,
                           int32_t spp) {
    char scene_path[1024], image_path[1024];
    if (!has_reference(name, scene_path, image_path)) skip();
    ty_scene* scene = NULL;
    ty_image *reference = NULL, *image = NULL;
    must(context, ty_scene_load(context, scene_path, NULL, 0, &scene));
    must(context, ty_image_read(context, image_path, &reference));
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.energy_compensation = compensated;
    must(context, ty_path_render(scene, &def, &image, NULL));
    ty_difference difference;
    must(context, ty_image_compare(context, image, reference, 8, &difference));
    printf("%-38s %s mean ratio %.5f; blocks: relative RMSE %.4f\n", name, compensated ? "compensated" : "single     ",
           difference.mean_ratio[3], difference.relative_rmse[3]);
    assert_int_equal(difference.not_finite, 0);
    if (!(fabs(difference.mean_ratio[3] - 1) <= tolerance))
        fail_msg("%s: mean ratio %g", name, difference.mean_ratio[3]);
    if (!(difference.relative_rmse[3] <= blocks))
        fail_msg("%s: blocks differ by %g", name, difference.relative_rmse[3]);
    ty_image_destroy(image);
    ty_image_destroy(reference);
    ty_scene_destroy(scene);
}

static int32_t samples(void) {
    return in_full() ? 512 : 16;
}

/* The same formulas: all that is left is noise. */
static void spheres_are_those_of_appendix_b(void** state) {
    check_material(*state, "spheres.own_appendixb_correlated", false, 0.002, in_full() ? 0.005 : 0.02, samples());
}

static void normal_maps_are_those_of_appendix_b(void** state) {
    check_material(*state, "normal_map.own_appendixb", false, 0.002, in_full() ? 0.005 : 0.02, samples());
}

/* Multiple scattering of a random walk over microfacets. Plastic is modelled otherwise there. */
static void compensated_spheres_are_near_a_random_walk_s(void** state) {
    check_material(*state, "spheres.cycles_multi_ggx", true, 0.01, in_full() ? 0.02 : 0.03, samples());
}

static void metal_in_fog_agrees(void** state) {
    check_material(*state, "metal_in_fog.cycles_multi_ggx", true, 0.005, in_full() ? 0.03 : 0.1, samples());
    check_material(*state, "metal_in_fog.cycles_ggx", false, 0.005, in_full() ? 0.03 : 0.1, samples());
}

/* Both have refraction with energy compensation; theirs is a random walk over the microfacets of the rough ball. */
static void glass_balls_agree(void** state) {
    check_material(*state, "glass_ball.cycles_multi_ggx", true, 0.01, in_full() ? 0.04 : 0.2, samples());
}

static void milk_in_a_ball_agrees(void** state) {
    check_material(*state, "milk.cycles_sharp", true, 0.01, in_full() ? 0.03 : 0.2, in_full() ? samples() / 2 : 2);
}

static void water_in_a_pool_agrees(void** state) {
    check_material(*state, "water.cycles_sharp", true, 0.01, in_full() ? 0.03 : 0.1, samples());
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres_are_those_of_appendix_b),
        cmocka_unit_test(normal_maps_are_those_of_appendix_b),
        cmocka_unit_test(compensated_spheres_are_near_a_random_walk_s),
        cmocka_unit_test(metal_in_fog_agrees),
        cmocka_unit_test(glass_balls_agree),
        cmocka_unit_test(milk_in_a_ball_agrees),
        cmocka_unit_test(water_in_a_pool_agrees),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
