/* Fig. 17 of the paper: a solid in a medium, and the light that it reflects into the medium. */
#include "figures/pop_view.h"

#include <string.h>

enum { VARIANTS = 2, WIDTH = 256, HEIGHT = 192, PICTURE_WIDTH = 384 };

static const char* const titles[VARIANTS] = {"without VPLs", "64 VPLs"};

ty_result figure_pop_surfaces(figure_run* run) {
    int32_t size[2];
    ty_scene* scene = NULL;
    figure_errors errors[VARIANTS];
    figure_view_size(run, WIDTH, HEIGHT, size);
    ty_result result = figure_load_scene(run, "pop_mist", NULL, 0, &scene);
    if (result == TY_OK) {
        ty_pop_def settings[VARIANTS];
        settings[0] = settings[1] = pop_scene_def(scene);
        settings[0].vpls = 0;
        const figure_variant variants[VARIANTS] = {{titles[0], pop_render_variant, &settings[0]},
                                                   {titles[1], pop_render_variant, &settings[1]}};
        result = figure_show_variants(run, "mist", scene, variants, VARIANTS, size, PICTURE_WIDTH, errors);
    }
    if (result == TY_OK)
        result = figure_expect(run, "VPLs over none", "relative RMSE", "1",
                               errors[1].relative_rmse / errors[0].relative_rmse, 0, 1);
    ty_scene_destroy(scene);
    figure_caption(run,
                   "Mist, σs = 0.5/m, g = 0.3, over a blue floor with a red ball and a green box, in the sun; what the "
                   "surfaces send back lights the mist from below. The surfaces themselves are path-traced.");
    figure_describe_errors(run, false);
    return result;
}
