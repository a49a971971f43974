/* Media that fill solid dielectrics, by ordinates and by diffusion, beside path tracing. */
#include "figures/view.h"

enum { METHODS = 2, DOM = 0, FLD = 1, PICTURE_WIDTH = 300 };

/* Samples per pixel of the images of surfaces, at which the paths' own noise is small in means over blocks. */
static const char* const samples = "render.spp=64";

static const figure_scene scenes[] = {
    {.title = "glass of whole milk",
     .scene = "milk_glass",
     .overrides = {samples},
     .quick = "render.spp=4",
     .width = 160,
     .height = 120},
    {.title = "ball of thin milk",
     .scene = "milk_ball",
     .overrides = {samples},
     .quick = "render.spp=4",
     .width = 160,
     .height = 120},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

ty_result figure_dom_milk(figure_run* run) {
    static const figure_variant variants[METHODS] = {{.title = "DOM", .method = &ty_method_dom},
                                                     {.title = "FLD", .method = &ty_method_fld}};
    ty_result result = TY_OK;
    for (int i = 0; i < SCENES && result == TY_OK; ++i) {
        figure_errors errors[METHODS];
        result = figure_show_scene(run, &scenes[i], variants, METHODS, PICTURE_WIDTH, errors);
        if (result != TY_OK) break;
        figure_expect(run, scenes[i].title, "mean ratio of DOM", "1", errors[DOM].mean_ratio, 1, 0.02);
        figure_expect(run, scenes[i].title, "relative RMSE of DOM", "1", errors[DOM].relative_rmse, 0, 0.06);
        figure_expect(run, scenes[i].title, "mean ratio of FLD", "1", errors[FLD].mean_ratio, 1, 0.03);
        figure_expect(run, scenes[i].title, "relative RMSE of FLD", "1", errors[FLD].relative_rmse, 0, 0.08);
    }
    figure_caption(run, "Milk with a smooth boundary, by path tracing, discrete ordinates and diffusion.");
    figure_describe_errors(run, true);
    return result;
}
