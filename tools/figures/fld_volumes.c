/* Figs. 8 and 9 of the paper, with freely available volumes: a CT scan through a transfer function, and a plume of
 * smoke with thermal emission. */
#include "figures/fld_view.h"

enum { CT_WIDTH = 256, FIRE_WIDTH = 216, FIRE_HEIGHT = 288 };

/* Tissue and bone have different albedos, and there is one light, as in the paper. */
/* file: third-party data that the scene needs. Errors: those of ty_scene_load. */
static ty_result show(figure_run* run, const char* file, const char* scene_name, const char* item, int32_t width,
                      int32_t height) {
    char path[FIGURE_PATH_SIZE];
    if (!figure_find_data(run, file, path)) return TY_OK;
    ty_scene* scene = NULL;
    ty_result result = figure_load_scene(run, scene_name, NULL, 0, &scene);
    if (result == TY_OK) result = fld_show_scene(run, scene, item, width, height);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_fld_ct(figure_run* run) {
    const ty_result result = show(run, CT_HEAD_FILE, "fld_ct_head", "CT head", CT_WIDTH, CT_WIDTH);
    figure_caption(run, "A head of 64 × 64 × 93 voxels (the paper's is not free), extinction and albedo by transfer "
                        "functions, lit from one side.");
    figure_describe_errors(run, true);
    return result;
}

ty_result figure_fld_fire(figure_run* run) {
    const ty_result result = show(run, PLUME_FILE, "fld_fire", "plume", FIRE_WIDTH, FIRE_HEIGHT);
    figure_caption(run, "Simulated smoke with an external light that glows as black bodies do (the paper's is not "
                        "free, and has an albedo of 1, with which nothing glows).");
    figure_describe_errors(run, true);
    return result;
}
