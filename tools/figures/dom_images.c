/* Clouds, smoke, a CT scan and nebulae by discrete ordinates, beside path tracing and the other volume methods. */
#include "figures/view.h"

enum { METHODS = 3, DOM = 0, PICTURE_WIDTH = 300 };

static const figure_scene scenes[] = {
    {.title = "Disney cloud", .file = DISNEY_CLOUD_FILE, .scene = "dom_disney_cloud", .width = 256, .height = 144},
    {.title = "plume", .file = PLUME_FILE, .scene = "dom_plume", .width = 192, .height = 256},
    {.title = "CT head", .file = CT_HEAD_FILE, .scene = "fld_ct_head", .width = 192, .height = 192},
    {.title = "nebulae",
     .scene = "builtin:nebulae",
     .width = 192,
     .height = 192,
     .quick = "media[0].density.noise.resolution=32"},
    {.title = "cloud in the sun",
     .scene = "builtin:cloud_sun",
     .width = 192,
     .height = 192,
     .quick = "media[0].density.noise.resolution=32"},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

/* DOM must be near path tracing, and nearer than the other methods. */
static ty_result expect_errors(figure_run* run, const char* item, const figure_errors errors[METHODS]) {
    ty_result result = TY_OK;
    figure_expect(run, item, "mean ratio of DOM", "1", errors[DOM].mean_ratio, 1, 0.03);
    figure_expect(run, item, "relative RMSE of DOM", "1", errors[DOM].relative_rmse, 0, 0.06);
    for (int other = DOM + 1; other < METHODS && result == TY_OK; ++other) {
        static const char* const names[METHODS] = {NULL, "relative RMSE of DOM over POP's",
                                                   "relative RMSE of DOM over FLD's"};
        figure_expect(run, item, names[other], "1", errors[DOM].relative_rmse / errors[other].relative_rmse, 0, 1);
    }
    return TY_OK;
}

ty_result figure_dom_images(figure_run* run) {
    static const figure_variant variants[METHODS] = {{.title = "DOM", .method = &ty_method_dom},
                                                     {.title = "POP", .method = &ty_method_pop},
                                                     {.title = "FLD", .method = &ty_method_fld}};
    ty_result result = TY_OK;
    for (int i = 0; i < SCENES && result == TY_OK; ++i) {
        figure_errors errors[METHODS];
        if (scenes[i].file != NULL && !figure_has_data(run, scenes[i].file)) continue;
        result = figure_show_scene(run, &scenes[i], variants, METHODS, PICTURE_WIDTH, errors);
        if (result == TY_OK) result = expect_errors(run, scenes[i].title, errors);
    }
    figure_caption(run, "By path tracing, discrete ordinates, principal ordinates and flux-limited diffusion, each by "
                        "its defaults: volumes that are free, where they are there, and two of noise.");
    figure_describe_errors(run, true);
    return result;
}
