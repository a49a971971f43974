/* fld and pop among surfaces, which reflect into media and absorb diffuse light, against path tracing, in absolute
 * units, over blocks of pixels. */
#include "truth_scene.h"

#include <tyndall/fld.h>
#include <tyndall/method.h>
#include <tyndall/pop.h>

/* Cases have what was measured, fld first. Means are held to 0.015 about the ratio, RMSEs to 0.02 above, margins for
 * path tracing's noise. */
static const double ratio_margin = 0.015, rmse_margin = 0.02;

typedef struct nearness {
    double ratio, rmse;
} nearness;

static ty_image* fld_image(const ty_scene* scene, const scene_case* c, const ty_image* surfaces) {
    ty_context* context = ty_scene_context(scene);
    ty_fld_def def = ty_default_fld_def();
    ty_fld_stats stats = ty_default_fld_stats();
    ty_image* image = NULL;
    must(context, ty_method_options(scene, "fld", &def));
    def.width = c->width;
    def.height = c->height;
    def.spp = 4;
    def.unscattered = surfaces;
    must(context, ty_fld_render(scene, &def, &image, &stats));
    assert_true(stats.converged);
    return image;
}

static ty_image* pop_image(const ty_scene* scene, const scene_case* c, const ty_image* surfaces) {
    ty_context* context = ty_scene_context(scene);
    ty_pop_def def = ty_default_pop_def();
    ty_pop_stats stats = ty_default_pop_stats();
    ty_image* image = NULL;
    must(context, ty_method_options(scene, "pop", &def));
    def.width = c->width;
    def.height = c->height;
    def.spp = 4;
    def.unscattered = surfaces;
    must(context, ty_pop_render(scene, &def, &image, &stats));
    assert_true(stats.converged);
    return image;
}

static void check_scene(ty_context* context, const scene_case* c, const nearness measured[2]) {
    ty_scene* scene = read_case(context, c);
    ty_image *truth = path_image(scene, c, 0), *surfaces = surfaces_of(scene, c);
    ty_image* images[2] = {fld_image(scene, c, surfaces), pop_image(scene, c, surfaces)};
    ty_difference d[2];
    printf("%s, mean ratio / relative RMSE:", c->path);
    for (int i = 0; i < 2; ++i) {
        assert_finite(images[i]);
        must(context, ty_image_compare(context, images[i], truth, BLOCK, &d[i]));
        printf(" %s %.4f / %.4f", i == 0 ? "fld" : "pop", d[i].mean_ratio[3], d[i].relative_rmse[3]);
        ty_image_destroy(images[i]);
    }
    printf("\n");
    ty_image_destroy(truth);
    ty_image_destroy(surfaces);
    ty_scene_destroy(scene);
    for (int i = 0; i < 2; ++i) {
        assert_true(fabs(d[i].mean_ratio[3] - measured[i].ratio) <= ratio_margin);
        assert_true(d[i].relative_rmse[3] <= measured[i].rmse + rmse_margin);
    }
}

static void a_box_in_fog(void** state) {
    const scene_case c = {"builtin:fog_cornell", NULL, {NULL}, 60, 60, fewer(256, 2), 0, 0, 0};
    static const nearness measured[] = {{0.957, 0.173}, {0.968, 0.166}};
    check_scene(*state, &c, measured);
}

static void an_atrium(void** state) {
    const scene_case c = {"builtin:atrium", NULL, {NULL}, 96, 54, fewer(256, 4), 0, 0, 0};
    static const nearness measured[] = {{0.918, 0.167}, {0.99, 0.164}};
    check_scene(*state, &c, measured);
}

static void sponza(void** state) {
    leave_to_full_runs();
    const scene_case c = {
        "scenes/sponza_lamps.json", "scenes/sponza_atrium.glb", {"geometry[0].file=\"%s\""}, 96, 54, 256, 0, 0, 0};
    static const nearness measured[] = {{0.898, 0.186}, {1.012, 0.113}};
    check_scene(*state, &c, measured);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_box_in_fog), cmocka_unit_test(an_atrium),
                                       cmocka_unit_test(sponza)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
