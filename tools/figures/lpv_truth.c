/* Figs. 7 and 8 of the paper: scenes in fog against path tracing, and simpler combinations of the method. */
#include "figures/lpv_view.h"

#include <math.h>

enum { SCENES = 3, VARIANTS = 8, TRUTH = 0, FULL = 1, BOTH = 2, MARCHED = 3, PICTURE_WIDTH = 250 };

static const lpv_variant variants[VARIANTS] = {
    {"path tracing", NULL, NULL, 0, 0, 0},        {"full", "links", "all", 0, 0, 0},
    {"both added (f)", "links", "both", 0, 0, 0}, {"plain, marched (e)", "links", "plain_march", 0, 0, 0},
    {"plain (c)", "links", "plain", 0, 0, 0},     {"full, published", "published", "all", 0, 0, 0},
    {"three bands", "links", "all", 0, 3, 0},     {"two cascades", "links", "all", 0, 0, 2},
};

static const struct {
    lpv_scene scene;
    int32_t size[2];
} scenes[SCENES] = {{LPV_SPONZA, {320, 180}}, {LPV_ATRIUM, {320, 180}}, {LPV_CORNELL, {192, 192}}};

/* Errors of a scene's variants. */
typedef struct comparison {
    figure_picture truth;
    ty_image* direct;
    figure_errors all[VARIANTS], shadow[VARIANTS];
} comparison;

static ty_result show_variant(figure_run* run, const char* name, ty_scene* scene, int v, const int32_t size[2],
                              comparison* compared, plot_sheet* sheet) {
    char item[FIGURE_NAME_SIZE];
    figure_picture picture = {0};
    const figure_picture* truth = v == TRUTH ? NULL : &compared->truth;
    plot_cell* cell = plot_sheet_cell(sheet, 0, v);
    snprintf(item, sizeof item, "%s, %s", name, variants[v].title);
    snprintf(sheet->column_titles[v], PLOT_LABEL_SIZE, "%s", variants[v].title);
    ty_result result = lpv_render(run, item, scene, &variants[v], size, &picture, NULL);
    if (result == TY_OK) result = figure_show(run, item, scene, &picture, truth, false, cell, &compared->all[v]);
    if (result == TY_OK && v != TRUTH)
        result = lpv_compare_shadow(run, item, &picture, truth, compared->direct, &compared->shadow[v]);
    if (result == TY_OK && v != TRUTH) {
        char error[16];
        figure_format_error(compared->shadow[v].relative_rmse, error);
        snprintf(cell->lines[2], PLOT_LABEL_SIZE, "in shadow %.3f, %s", compared->shadow[v].mean_ratio, error);
        result = figure_error_map(run, picture.image, truth->image, figure_block(truth->image),
                                  &plot_sheet_cell(sheet, 1, v)->picture);
    }
    if (v == TRUTH)
        compared->truth = picture;
    else
        figure_free_picture(&picture);
    return result;
}

/* Criteria: means within 20 %, and half of the error of the simpler combinations. */
static ty_result expect(figure_run* run, const char* name, const comparison* compared) {
    const figure_errors* all = compared->all;
    ty_result result = figure_expect(run, name, "mean ratio of full", "1", all[FULL].mean_ratio, 1, 0.2);
    if (result == TY_OK)
        result = figure_expect(run, name, "relative RMSE of full over that of both added", "1",
                               all[FULL].relative_rmse / all[BOTH].relative_rmse, 0, 0.5);
    if (result == TY_OK)
        result = figure_expect(run, name, "relative RMSE of full over that of plain, marched", "1",
                               all[FULL].relative_rmse / all[MARCHED].relative_rmse, 0, 0.5);
    return result;
}

static ty_result show_scene(figure_run* run, ty_scene* scene, int s, plot_sheet* sheet) {
    int32_t size[2];
    comparison compared = {0};
    const char* name = lpv_scene_names[scenes[s].scene];
    figure_view_size(run, scenes[s].size[0], scenes[s].size[1], size);
    snprintf(sheet->row_titles[0], PLOT_LABEL_SIZE, "%s", name);
    snprintf(sheet->row_titles[1], PLOT_LABEL_SIZE, "errors");
    ty_result result = lpv_render_direct(scene, size, &compared.direct);
    for (int v = 0; v < VARIANTS && result == TY_OK; ++v)
        result = show_variant(run, name, scene, v, size, &compared, sheet);
    if (result == TY_OK) result = expect(run, name, &compared);
    ty_image_destroy(compared.direct);
    figure_free_picture(&compared.truth);
    return result;
}

static ty_result add_scene(figure_run* run, int s) {
    ty_scene* scene = NULL;
    plot_sheet sheet;
    if (scenes[s].scene == LPV_SPONZA && !tools_has_data(run->options->data, SPONZA_FILE)) return TY_OK;
    ty_result result = plot_create_sheet(2, VARIANTS, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    result = figure_load_scene(run, lpv_scene_files[scenes[s].scene], NULL, 0, &scene);
    if (result == TY_OK) result = show_scene(run, scene, s, &sheet);
    figure_place_sheet(run, result, &sheet, NULL);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_lpv_truth(figure_run* run) {
    ty_result result = TY_OK;
    for (int s = 0; s < SCENES && result == TY_OK; ++s) result = add_scene(run, s);
    if (result == TY_OK) plot_page_color_bar(&run->page, &figure_error_scale);
    figure_caption(run,
                   "Scenes in fog%s: the method against path tracing, and combinations of the paper's Fig. 5 by the "
                   "same lattice: light propagation volumes on surfaces alone (c), these marched (e), and single "
                   "scattering added (f); the full method with three bands, and with a finer lattice about the camera. "
                   "In shadow: blocks of pixels whose surfaces no light reaches directly. Errors are of means over %d "
                   "× %d pixels, the relative RMSE without the truth's own noise.",
                   tools_has_data(run->options->data, SPONZA_FILE) ? "" : " (Sponza's data are not there)",
                   FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}
