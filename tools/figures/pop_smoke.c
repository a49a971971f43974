/* Fig. 11 of the paper: smoke in an environment, at two settings, in published and default mode, compared with the
 * classical solver of the paper and with method dom. */
#include "figures/classical.h"
#include "figures/dom_view.h"

#include <math.h>
#include <string.h>

enum { POP = 4, CLASSICAL = 2, DOM = POP + CLASSICAL, VARIANTS = DOM + 1 };
enum { WIDTH = 224, HEIGHT = 288, PICTURE_WIDTH = 250 };

static const char sky_file[] = "hdri/potsdamer_platz_1k.hdr";

/* 5 m high. */
static const struct {
    const char* title;
    ty_pop_mode mode;
    int32_t ordinates, resolution, iterations;
} settings[POP] = {{"split, 64 × 20³", TY_POP_MODE_SPLIT, 64, 20, TY_AUTO},
                   {"split, 125 × 50³", TY_POP_MODE_SPLIT, 125, 50, TY_AUTO},
                   {"published, 64 × 20³", TY_POP_MODE_PUBLISHED, 64, 20, 10},
                   {"published, 125 × 50³", TY_POP_MODE_PUBLISHED, 125, 50, 30}};

/* Settings of the paper's SHDOM. */
static const struct {
    const char* title;
    classical_setting setting, quick;
} classical[CLASSICAL] = {{"classical, 5 bands, 20³", {5, 20, 96}, {5, 10, 48}},
                          {"classical, 10 bands, 50³", {10, 50, 200}, {10, 12, 96}}};

/* Without third-party data, noise replaces the plume and a synthetic room the photographed environment. */
static ty_result make_scene(figure_run* run, bool* own, ty_scene** out) {
    const bool found = figure_has_data(run, PLUME_FILE) && figure_has_data(run, sky_file);
    *own = !found;
    if (found) return figure_load_scene(run, "pop_plume_5m", NULL, 0, out);
    return pop_make_smoke(run, NULL, 0, out);
}

static ty_result show(figure_run* run, ty_scene* scene) {
    const bool quick = run->options->quick;
    int32_t size[2];
    ty_pop_def pop[POP];
    figure_variant shown[VARIANTS];
    figure_errors errors[VARIANTS];
    figure_view_size(run, WIDTH, HEIGHT, size);
    for (int i = 0; i < POP; ++i) {
        pop[i] = pop_scene_def(scene);
        pop[i].mode = settings[i].mode;
        pop[i].ordinates = settings[i].ordinates;
        pop[i].resolution = quick ? settings[i].resolution / 2 : settings[i].resolution;
        pop[i].iterations = settings[i].iterations;
        shown[i] = (figure_variant){settings[i].title, pop_render_variant, &pop[i]};
    }
    for (int i = 0; i < CLASSICAL; ++i)
        shown[POP + i] =
            (figure_variant){classical[i].title, classical_render, quick ? &classical[i].quick : &classical[i].setting};
    shown[DOM] = (figure_variant){"dom", dom_render_variant, NULL};
    ty_result result = figure_show_variants(run, "smoke", scene, shown, VARIANTS, size, PICTURE_WIDTH, errors);
    for (int i = 0; i < 2 && result == TY_OK; ++i)
        result = figure_expect(run, settings[i].title, "mean ratio", "1", errors[i].mean_ratio, 1, 0.1);
    if (result == TY_OK) result = figure_expect(run, "dom", "mean ratio", "1", errors[DOM].mean_ratio, 1, 0.03);
    if (result == TY_OK)
        result = figure_expect(
            run, "dom over the better classical", "relative RMSE", "1",
            errors[DOM].relative_rmse / fmin(errors[POP].relative_rmse, errors[POP + 1].relative_rmse), 0, 1);
    return result;
}

ty_result figure_pop_smoke(figure_run* run) {
    ty_scene* scene = NULL;
    bool own = false;
    ty_result result = make_scene(run, &own, &scene);
    if (result == TY_OK) result = show(run, scene);
    ty_scene_destroy(scene);
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
