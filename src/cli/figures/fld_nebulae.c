/* Figs. 1 and 6 of the paper: a nebula in vacuum, and what solving it on a coarser grid costs. */
#include "cli/figures/fld_view.h"

#include <math.h>

enum { WIDTH = 256, VOXELS_QUICK = 48, VOXELS_RESOLUTION = 100, PICTURE_WIDTH = 384, RATIO = 4 };

static const char scene_name[] = "builtin:nebulae";

/* The scene with so many voxels along each side; 0: its own number. ratio: see ty_fld_def. */
static ty_result load(figure_run* run, int voxels, double ratio, ty_scene** out) {
    char resolution[64], coarseness[64];
    const char* const overrides[2] = {coarseness, resolution};
    snprintf(coarseness, sizeof coarseness, "render.fld.ratio=%g", ratio);
    snprintf(resolution, sizeof resolution, "media[0].density.noise.resolution=%d", voxels);
    return ty_scene_load(run->session->context, scene_name, overrides, voxels > 0 ? 2 : 1, out);
}

ty_result figure_fld_nebulae(figure_run* run) {
    ty_scene* scene = NULL;
    ty_result result = load(run, run->options->quick ? VOXELS_QUICK : 0, 0, &scene);
    if (result == TY_OK) result = fld_show_scene(run, scene, "nebulae", WIDTH, WIDTH);
    ty_scene_destroy(scene);
    snprintf(
        run->caption, sizeof run->caption,
        "The builtin scene nebulae, albedo 0.9, lit from above: an arch with a ball in its shadow, in vacuum. "
        "Diffusion is solved on a grid of a quarter of the resolution. Errors are of means over %d × %d pixels, the "
        "relative RMSE without the truth's own noise.",
        FLD_BLOCK, FLD_BLOCK);
    return result;
}

/* ---- full against quarter resolution ---- */

/* One picture of the sheet. */
static ty_result render_ratio(figure_run* run, const char* item, double ratio, const int32_t size[2],
                              fld_picture* picture, plot_cell* cell) {
    ty_scene* scene = NULL;
    ty_result result = load(run, run->options->quick ? VOXELS_QUICK : VOXELS_RESOLUTION, ratio, &scene);
    if (result == TY_OK) result = fld_render(run, item, scene, FLD_LIMITED, size, picture);
    if (result == TY_OK)
        result = plot_picture_of_image(run->session->context, picture->image, ty_scene_camera(scene).exposure,
                                       &cell->picture);
    ty_scene_destroy(scene);
    return result;
}

static ty_result fill_resolution(figure_run* run, plot_sheet* sheet) {
    int32_t size[2];
    fld_picture full = {0}, coarse = {0};
    ty_difference difference;
    fld_view_size(run, WIDTH, WIDTH, size);
    ty_result result = render_ratio(run, "full resolution", 1, size, &full, plot_sheet_cell(sheet, 0, 0));
    if (result == TY_OK)
        result = render_ratio(run, "quarter resolution", RATIO, size, &coarse, plot_sheet_cell(sheet, 0, 1));
    if (result == TY_OK) result = ty_image_compare(run->session->context, coarse.image, full.image, 1, &difference);
    if (result == TY_OK)
        result = figure_expect(run, "quarter against full", "relative RMSE", "1", difference.relative_rmse[3], 0, 0.03);
    if (result == TY_OK)
        result = figure_expect(run, "quarter against full", "mean ratio", "1", difference.mean_ratio[3], 1, 0.03);
    if (result == TY_OK)
        result = figure_error_map(run, coarse.image, full.image, 1, &plot_sheet_cell(sheet, 0, 2)->picture);
    if (result == TY_OK) {
        snprintf(plot_sheet_cell(sheet, 0, 0)->lines[0], PLOT_LABEL_SIZE, "%.3g s", full.seconds);
        snprintf(plot_sheet_cell(sheet, 0, 1)->lines[0], PLOT_LABEL_SIZE, "%.3g s", coarse.seconds);
        snprintf(plot_sheet_cell(sheet, 0, 2)->lines[0], PLOT_LABEL_SIZE, "mean ratio %.4f, relative RMSE %.4f",
                 difference.mean_ratio[3], difference.relative_rmse[3]);
    }
    fld_free_picture(&full);
    fld_free_picture(&coarse);
    return result;
}

ty_result figure_fld_resolution(figure_run* run) {
    const int voxels = run->options->quick ? VOXELS_QUICK : VOXELS_RESOLUTION;
    plot_sheet sheet;
    ty_result result = plot_create_sheet(1, 3, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    snprintf(sheet.column_titles[0], PLOT_LABEL_SIZE, "FLD on %d³ cells", voxels);
    snprintf(sheet.column_titles[1], PLOT_LABEL_SIZE, "FLD on %d³ cells", voxels / RATIO);
    snprintf(sheet.column_titles[2], PLOT_LABEL_SIZE, "difference");
    result = fill_resolution(run, &sheet);
    if (result == TY_OK) {
        plot_page_sheet(&run->page, &sheet);
        plot_page_color_bar(&run->page, &figure_error_scale);
    }
    plot_free_sheet(&sheet);
    snprintf(
        run->caption, sizeof run->caption,
        "The builtin scene nebulae of %d³ voxels. Light that scatters more than once is solved for on as many cells, "
        "and on a quarter of them along each side; light that scatters once is as sharp in both.",
        voxels);
    return result;
}
