/* Fig. 11 of the paper: smoke in an environment, at two settings, in published and default mode, compared with the
 * classical solver of the paper and with method dom. */
#include "figures/classical.h"

#include <math.h>

enum { POP = 4, CLASSICAL = 2, DOM = POP + CLASSICAL, VARIANTS = DOM + 1 };
enum { WIDTH = 224, HEIGHT = 288, PICTURE_WIDTH = 250 };

static const char sky_file[] = "hdri/potsdamer_platz_1k.hdr";

/* 5 m high. Settings of the paper's SHDOM. */
static const classical_setting classical[CLASSICAL] = {{5, 20, 96}, {10, 50, 200}},
                               classical_quick[CLASSICAL] = {{5, 10, 48}, {10, 12, 96}};

/* Half of the cells with --quick. */
static const char* const options[2][POP] = {
    {"mode=split ordinates=64 resolution=20 iterations=auto", "mode=split ordinates=125 resolution=50 iterations=auto",
     "mode=published ordinates=64 resolution=20 iterations=10",
     "mode=published ordinates=125 resolution=50 iterations=30"},
    {"mode=split ordinates=64 resolution=10 iterations=auto", "mode=split ordinates=125 resolution=25 iterations=auto",
     "mode=published ordinates=64 resolution=10 iterations=10",
     "mode=published ordinates=125 resolution=25 iterations=30"}};

static ty_result show(figure_run* run, const figure_scene* scene) {
    const bool quick = run->options->quick;
    const classical_setting* setting = quick ? classical_quick : classical;
    const figure_variant variants[VARIANTS] = {
        {.title = "split, 64 × 20³", .method = &ty_method_pop, .options = options[quick][0]},
        {.title = "split, 125 × 50³", .method = &ty_method_pop, .options = options[quick][1]},
        {.title = "published, 64 × 20³", .method = &ty_method_pop, .options = options[quick][2]},
        {.title = "published, 125 × 50³", .method = &ty_method_pop, .options = options[quick][3]},
        {.title = "classical, 5 bands, 20³", .render = classical_render, .user = &setting[0]},
        {.title = "classical, 10 bands, 50³", .render = classical_render, .user = &setting[1]},
        {.title = "dom", .method = &ty_method_dom}};
    figure_errors errors[VARIANTS];
    ty_result result = figure_show_scene(run, scene, variants, VARIANTS, PICTURE_WIDTH, errors);
    for (int i = 0; i < 2 && result == TY_OK; ++i)
        figure_expect(run, variants[i].title, "mean ratio", "1", errors[i].mean_ratio, 1, 0.1);
    if (result == TY_OK) figure_expect(run, "dom", "mean ratio", "1", errors[DOM].mean_ratio, 1, 0.03);
    if (result == TY_OK)
        figure_expect(run, "dom over the better classical", "relative RMSE", "1",
                      errors[DOM].relative_rmse / fmin(errors[POP].relative_rmse, errors[POP + 1].relative_rmse), 0, 1);
    return result;
}

/* Without third-party data, noise replaces the plume and a synthetic room the photographed environment. */
ty_result figure_pop_smoke(figure_run* run) {
    static const figure_scene plume = {.title = "smoke", .scene = "pop_plume_5m", .width = WIDTH, .height = HEIGHT},
                              noise = {.title = "smoke",
                                       .scene = "pop_smoke",
                                       .width = WIDTH,
                                       .height = HEIGHT,
                                       .windows = true};
    const bool own = !figure_has_data(run, PLUME_FILE) || !figure_has_data(run, sky_file);
    const ty_result result = show(run, own ? &noise : &plume);
    figure_caption(
        run,
        "%s, σs = {2.9, 3.6, 4.2}/m, σa = {3.4, 3.35, 3.4}/m, g = 0.9; ordinates × cells, published with 10 and 30 "
        "iterations; classical discrete ordinates, 96 and 200 of them, in bands of spherical harmonics that fade to "
        "the last, the environment let in through the faces.",
        own ? "Smoke of noise, 2 m across, in a room with windows and a lamp (the plume's data are not there)"
            : "Simulated smoke, 5 m high, in a photographed square (the paper's are not free)");
    figure_describe_errors(run, true);
    return result;
}
