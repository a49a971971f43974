/* Figs. 6, 7, 15 and 17 of the paper: scenes by principal-ordinates propagation against path tracing. */
#include "figures/view.h"

/* ---- Fig. 6: thin slabs before windows, without and with prefiltering over the solid angle of ordinates ---- */

#define SLAB(cosine)                                                                                                   \
    {                                                                                                                  \
        .title = "g = " #cosine, .item = "g " #cosine, .scene = "pop_slab", .overrides = {"media[0].g=" #cosine},      \
        .width = 160, .height = 160, .windows = true                                                                   \
    }

ty_result figure_pop_prefilter(figure_run* run) {
    static const figure_scene scenes[] = {SLAB(0.95), SLAB(0.98), SLAB(0.99), SLAB(0.999)};
    const figure_variant variants[] = {
        figure_path,
        {.title = "without prefiltering", .method = &ty_method_pop, .options = "ordinates=27 prefilter=0"},
        {.title = "β = 1", .method = &ty_method_pop, .options = "ordinates=27 prefilter=1"},
        {.title = "β = 4", .method = &ty_method_pop, .options = "ordinates=27 prefilter=4"}};
    figure_matrix matrix = {.scenes = scenes, .scene_count = 4, .variants = variants, .variant_count = 4};
    const ty_result result = figure_show_matrix(run, &matrix, 280);
    figure_free_matrix(&matrix);
    figure_caption(run, "A slab 0.2 m thick, σs = 40/m, before the windows of a room; 27 ordinates. Without "
                        "prefiltering each ordinate shows where scattering widens its light little.");
    figure_describe_errors(run, true);
    return result;
}

/* ---- Fig. 7: few ordinates, without and with importance sampling for the camera ---- */

ty_result figure_pop_importance(figure_run* run) {
    static const figure_scene scene = {.title = "g 0.98, 27 ordinates",
                                       .scene = "pop_smoke",
                                       .overrides = {"media[0].g=0.98", "media[0].sigma_s=20", "media[0].sigma_a=0.1"},
                                       .width = 256,
                                       .height = 256,
                                       .windows = true};
    static const figure_variant variants[2] = {
        {.title = "without importance", .method = &ty_method_pop, .options = "ordinates=27 importance=false"},
        {.title = "with importance", .method = &ty_method_pop, .options = "ordinates=27"}};
    figure_errors errors[2];
    ty_result result = figure_show_scene(run, &scene, variants, 2, 384, errors);
    if (result == TY_OK)
        figure_expect(run, "importance over none", "relative RMSE", "1",
                      errors[1].relative_rmse / errors[0].relative_rmse, 0, 1);
    figure_caption(run, "The smoke of pop-ordinates with σs = 20/m, σa = 0.1/m and g = 0.98, and 27 ordinates. "
                        "Importance prefers directions whose light the camera sees most of, such as that of the "
                        "windows behind the smoke.");
    figure_describe_errors(run, false);
    return result;
}

/* ---- Fig. 15: clouds with strong forward scattering ---- */

ty_result figure_pop_clouds(figure_run* run) {
    static const figure_scene scenes[] = {
        {.title = "g = 0.96", .scene = "pop_cloud", .overrides = {"media[0].g=0.96"}, .width = 256, .height = 256},
        {.title = "isotropic", .scene = "pop_cloud", .overrides = {"media[0].g=0"}, .width = 256, .height = 256}};
    const figure_variant variants[] = {
        figure_path, {.title = "split", .method = &ty_method_pop}, {.title = "FLD", .method = &ty_method_fld}};
    figure_matrix matrix = {.scenes = scenes, .scene_count = 2, .variants = variants, .variant_count = 3};
    ty_result result = figure_show_matrix(run, &matrix, 384);
    for (int i = 0; i < 2 && result == TY_OK; ++i)
        figure_expect(run, scenes[i].title, "mean ratio of split", "1", matrix.errors[i][1].mean_ratio, 1, 0.1);
    if (result == TY_OK)
        figure_expect(run, scenes[0].title, "relative RMSE of split over FLD's", "1",
                      matrix.errors[0][1].relative_rmse / matrix.errors[0][2].relative_rmse, 0, 1);
    figure_free_matrix(&matrix);
    figure_caption(run, "A cloud of noise, 96³ voxels, σt = 60/m, albedo 0.999, against a low sun behind it; 64 "
                        "ordinates of 20³ cells for the sky, the sun through cells as fine as the voxels.");
    figure_describe_errors(run, true);
    return result;
}

/* ---- Fig. 17: a solid in a medium, and the light that it reflects into the medium ---- */

ty_result figure_pop_surfaces(figure_run* run) {
    static const figure_scene scene = {.title = "mist", .scene = "pop_mist", .width = 256, .height = 192};
    static const figure_variant variants[2] = {
        {.title = "without interreflection", .method = &ty_method_pop, .options = "interreflection=false"},
        {.title = "with it", .method = &ty_method_pop}};
    figure_errors errors[2];
    const ty_result result = figure_show_scene(run, &scene, variants, 2, 384, errors);
    figure_caption(run,
                   "Mist, σs = 0.5/m, g = 0.3, over a blue floor with a red ball and a green box, in the sun; what the "
                   "surfaces send back lights the mist from below. The surfaces themselves are path-traced.");
    figure_describe_errors(run, false);
    return result;
}
