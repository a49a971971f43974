/* Images by flux-limited diffusion against path tracing, in absolute units, and against classical diffusion, over
 * blocks of pixels. `single` is more than it is by path tracing: with the reduced beam, light that scattering sent
 * nearly straight on is still uncollided. */
#include "truth_scene.h"

static ty_image* fld_image(const ty_scene* scene, const scene_case* c, const ty_image* surfaces, ty_fld_limiter limiter,
                           double ratio) {
    ty_fld_def def = ty_default_fld_def();
    ty_image* image = NULL;
    ty_fld_stats stats = ty_default_fld_stats();
    def.width = c->width;
    def.height = c->height;
    def.spp = 4;
    def.aovs = DETAILS;
    def.unscattered = surfaces;
    def.limiter = limiter;
    def.ratio = ratio;
    must(ty_scene_context(scene), ty_fld_render(scene, &def, &image, &stats));
    if (!stats.converged) fail_msg("%s: not converged", c->path);
    assert_finite(image);
    return image;
}

/* Prints how all layers differ, and gives the difference of R, G and B. */
static ty_difference compare(ty_context* context, const char* name, const ty_image* image, const ty_image* truth) {
    static const char* const layers[] = {"multiple", "single", "transmittance", ""};
    ty_difference difference;
    printf("  %-22s", name);
    for (int l = 0; l < 4; ++l) {
        ty_image *a = NULL, *b = NULL;
        must(context, ty_image_create_layer(context, image, layers[l], &a));
        must(context, ty_image_create_layer(context, truth, layers[l], &b));
        must(context, ty_image_compare(context, a, b, BLOCK, &difference));
        printf(" %s %.4f / %.4f", l == 3 ? "all" : layers[l], difference.mean_ratio[3], difference.relative_rmse[3]);
        ty_image_destroy(a);
        ty_image_destroy(b);
    }
    printf("\n");
    return difference;
}

static void check_quarter(const ty_scene* scene, const scene_case* c, const ty_image* surfaces) {
    ty_context* context = ty_scene_context(scene);
    ty_image* full = fld_image(scene, c, surfaces, TY_FLD_LIMITER_LEVERMORE_POMRANING, 1);
    ty_image* quarter = fld_image(scene, c, surfaces, TY_FLD_LIMITER_LEVERMORE_POMRANING, 4);
    ty_difference difference;
    must(context, ty_image_compare(context, quarter, full, 1, &difference));
    printf("  a quarter of the resolution against all of it: %.4f / %.4f\n", difference.mean_ratio[3],
           difference.relative_rmse[3]);
    assert_true(difference.relative_rmse[3] <= c->quarter);
    ty_image_destroy(full);
    ty_image_destroy(quarter);
}

static void check_case(ty_context* context, const scene_case* c) {
    ty_scene* scene = read_case(context, c);
    ty_image *truth = path_image(scene, c, 0), *other = in_full() ? path_image(scene, c, 1) : NULL;
    ty_image* surfaces = surfaces_of(scene, c);
    ty_image* fld = fld_image(scene, c, surfaces, TY_FLD_LIMITER_LEVERMORE_POMRANING, TY_AUTO);
    ty_image* cda = fld_image(scene, c, surfaces, TY_FLD_LIMITER_NONE, TY_AUTO);
    printf("%s, mean ratio / relative RMSE:\n", c->path);
    if (other != NULL) compare(context, "path, another seed", other, truth);
    const ty_difference limited = compare(context, "fld", fld, truth);
    const ty_difference classical = compare(context, "cda", cda, truth);
    assert_true(fabs(limited.mean_ratio[3] - 1) <= 0.1);
    assert_true(limited.relative_rmse[3] <= c->rmse);
    assert_true(limited.relative_rmse[3] < classical.relative_rmse[3]);
    if (c->quarter > 0 && in_full()) check_quarter(scene, c, surfaces);
    ty_image_destroy(fld);
    ty_image_destroy(cda);
    ty_image_destroy(surfaces);
    ty_image_destroy(truth);
    ty_image_destroy(other);
    ty_scene_destroy(scene);
}

static void cube_scattering_evenly(void** state) {
    check_case(*state, &(scene_case){"builtin:cube_g0", NULL, {NULL}, 48, 48, fewer(256, 2), 0.12, 0, 0});
}

static void cube_scattering_forwards(void** state) {
    check_case(*state, &(scene_case){"builtin:cube_g0.7", NULL, {NULL}, 48, 48, 256, 0.28, 0, 0});
}

static void cloud_in_sunlight(void** state) {
    check_case(*state, &(scene_case){"builtin:cloud_sun", NULL, {NULL}, 48, 48, fewer(256, 2), 0.15, 0.02, 0});
}

static void cloud_under_a_sky(void** state) {
    check_case(*state, &(scene_case){"builtin:cloud_sky", NULL, {NULL}, 48, 48, 128, 0.03, 0, 0});
}

static void measured_cloud(void** state) {
    leave_to_full_runs();
    static const char data[] = "volumes/wdas_cloud_sixteenth.vdb";
    check_case(*state, &(scene_case){"scenes/disney_cloud_sun.json", data, {DENSITY}, 48, 36, 128, 0.09, 0.075, 0});
}

static void smoke(void** state) {
    leave_to_full_runs();
    static const char data[] = "volumes/plume/plume_0042.vdb";
    check_case(*state, &(scene_case){"scenes/plume.json", data, {DENSITY}, 36, 48, 128, 0.14, 0, 0});
}

static void burning_smoke(void** state) {
    static const char data[] = "volumes/plume/plume_0042.vdb";
    static const char heat[] = "media[0].emission.temperature.file=\"%s\"";
    char path[1024], file[1200];
    snprintf(file, sizeof file, heat, data_path(data, path));
    check_case(*state,
               &(scene_case){"scenes/plume_fire.json", data, {DENSITY, file}, 36, 48, fewer(256, 4), 0.4, 0, 0});
}

/* Bone and skin, a tenth as dense as the scene has them. */
static void translucent_head(void** state) {
    static const char data[] = "volumes/headsq_ct_64x64x93_i16.nrrd";
    static const char* const thin = "media[0].sigma_t=500";
    check_case(*state, &(scene_case){"scenes/ct_head.json", data, {DENSITY, thin}, 48, 48, fewer(256, 4), 0.16, 0, 0});
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_scattering_evenly), cmocka_unit_test(cube_scattering_forwards),
        cmocka_unit_test(cloud_in_sunlight),      cmocka_unit_test(cloud_under_a_sky),
        cmocka_unit_test(measured_cloud),         cmocka_unit_test(smoke),
        cmocka_unit_test(burning_smoke),          cmocka_unit_test(translucent_head),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
