/* Fig. 17 of the paper: a solid in a medium, and the light that it sends into it. */
#include "figures/pop_view.h"

#include <string.h>

enum { VARIANTS = 2, WIDTH = 256, HEIGHT = 192, PICTURE_WIDTH = 384 };

static const char* const titles[VARIANTS] = {"without VPLs", "64 VPLs"};

static const char room_text[] =
    "{\"tyndall\": 1,"
    " \"camera\": {\"position\": [0, 1.1, 5.2], \"target\": [0, 0.75, 0], \"fov_y\": 36, \"resolution\": [256, 192],"
    "  \"exposure\": 0.2},"
    " \"media\": [{\"name\": \"mist\", \"bounds\": [[-1.8, 0.01, -1.2], [1.8, 2, 1.2]], \"sigma_s\": 0.5, \"sigma_a\": "
    "0.02,"
    "  \"g\": 0.3}],"
    " \"lights\": [{\"type\": \"directional\", \"direction\": [-0.55, -1, -0.25], \"irradiance\": 3}],"
    " \"geometry\": [{\"quad\": {\"origin\": [-4, 0, 4], \"u\": [8, 0, 0], \"v\": [0, 0, -8]},"
    "   \"material\": {\"albedo\": [0.15, 0.25, 0.75]}},"
    "  {\"sphere\": {\"center\": [-0.5, 0.6, 0], \"radius\": 0.55}, \"material\": {\"albedo\": [0.9, 0.3, 0.15]}},"
    "  {\"box\": [[0.5, 0.01, -0.5], [1.1, 0.7, 0.1]], \"material\": {\"albedo\": [0.3, 0.85, 0.25]}}]}";

ty_result figure_pop_surfaces(figure_run* run) {
    int32_t size[2];
    ty_scene* scene = NULL;
    figure_errors errors[VARIANTS];
    figure_view_size(run, WIDTH, HEIGHT, size);
    ty_result result =
        ty_scene_parse(run->session->context, room_text, strlen(room_text), "mist", NULL, NULL, 0, &scene);
    if (result == TY_OK) {
        ty_pop_settings settings[VARIANTS];
        settings[0] = settings[1] = ty_scene_render_settings(scene).pop;
        settings[0].vpls = 0;
        const figure_variant variants[VARIANTS] = {{titles[0], pop_render_variant, &settings[0]},
                                                   {titles[1], pop_render_variant, &settings[1]}};
        result = figure_show_variants(run, "mist", scene, variants, VARIANTS, size, PICTURE_WIDTH, errors);
    }
    if (result == TY_OK)
        result = figure_expect(run, "VPLs over none", "relative RMSE", "1",
                               errors[1].relative_rmse / errors[0].relative_rmse, 0, 1);
    ty_scene_destroy(scene);
    snprintf(run->caption, sizeof run->caption,
             "Mist, σs = 0.5/m, g = 0.3, over a blue floor with a red ball and a green box, in the sun; what the "
             "surfaces send back lights the mist from below. The surfaces themselves are path-traced. Errors are of "
             "means over %d × %d pixels.",
             FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}
