/* Clouds, smoke, a CT scan and nebulae by discrete ordinates, beside path tracing and the other volume methods. */
#include "figures/dom_view.h"

#include <string.h>

enum { METHODS = 3, DOM = 0, PICTURE_WIDTH = 300 };

/* file: third-party data that a scene needs, or NULL. */
typedef struct image_scene {
    const char *item, *file, *scene;
    int32_t width, height;
} image_scene;

static const image_scene scenes[] = {
    {"Disney cloud", DISNEY_CLOUD_FILE, "dom_disney_cloud", 256, 144},
    {"plume", PLUME_FILE, "dom_plume", 192, 256},
    {"CT head", CT_HEAD_FILE, "fld_ct_head", 192, 192},
    {"nebulae", NULL, "builtin:nebulae", 192, 192},
    {"cloud in the sun", NULL, "builtin:cloud_sun", 192, 192},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

static ty_result load(figure_run* run, const image_scene* from, ty_scene** out) {
    const char* const coarse[1] = {"media[0].density.noise.resolution=32"};
    return figure_load_scene(run, from->scene, coarse, from->file == NULL && run->options->quick ? 1 : 0, out);
}

/* The bounds. */
static ty_result expect_errors(figure_run* run, const char* item, const figure_errors errors[METHODS]) {
    ty_result result = figure_expect(run, item, "mean ratio of DOM", "1", errors[DOM].mean_ratio, 1, 0.03);
    if (result == TY_OK)
        result = figure_expect(run, item, "relative RMSE of DOM", "1", errors[DOM].relative_rmse, 0, 0.06);
    for (int other = DOM + 1; other < METHODS && result == TY_OK; ++other) {
        static const char* const names[METHODS] = {NULL, "relative RMSE of DOM over POP's",
                                                   "relative RMSE of DOM over FLD's"};
        result =
            figure_expect(run, item, names[other], "1", errors[DOM].relative_rmse / errors[other].relative_rmse, 0, 1);
    }
    return result;
}

static ty_result show_scene(figure_run* run, const image_scene* from) {
    static const figure_variant variants[METHODS] = {{"DOM", dom_render_variant, NULL},
                                                     {"POP", figure_render_by_method, &ty_method_pop},
                                                     {"FLD", figure_render_by_method, &ty_method_fld}};
    int32_t size[2];
    figure_errors errors[METHODS];
    ty_scene* scene = NULL;
    figure_view_size(run, from->width, from->height, size);
    ty_result result = load(run, from, &scene);
    if (result == TY_OK)
        result = figure_show_variants(run, from->item, scene, variants, METHODS, size, PICTURE_WIDTH, errors);
    if (result == TY_OK) result = expect_errors(run, from->item, errors);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_dom_images(figure_run* run) {
    ty_result result = TY_OK;
    for (int i = 0; i < SCENES && result == TY_OK; ++i)
        if (scenes[i].file == NULL || figure_has_data(run, scenes[i].file)) result = show_scene(run, &scenes[i]);
    figure_caption(run, "By path tracing, discrete ordinates, principal ordinates and flux-limited diffusion, each by "
                        "its defaults: volumes that are free, where they are there, and two of noise.");
    figure_describe_errors(run, true);
    return result;
}
