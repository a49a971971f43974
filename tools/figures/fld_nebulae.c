/* Figs. 1 and 6 of the paper: a nebula in vacuum, and the error of coarser grids. */
#include "figures/fld_view.h"

#include <math.h>

enum { WIDTH = 256, VOXELS = 200, VOXELS_QUICK = 48, PICTURE_WIDTH = 384, GRIDS = 3 };

static const char scene_name[] = "builtin:nebulae";

/* The scene with a number of voxels along each side. ratio: see ty_fld_def. */
static ty_result load(figure_run* run, int voxels, double ratio, ty_scene** out) {
    char resolution[64], coarseness[64];
    const char* const overrides[2] = {coarseness, resolution};
    if (ratio == TY_AUTO)
        snprintf(coarseness, sizeof coarseness, "render.fld.ratio=auto");
    else
        snprintf(coarseness, sizeof coarseness, "render.fld.ratio=%g", ratio);
    snprintf(resolution, sizeof resolution, "media[0].density.noise.resolution=%d", voxels);
    return ty_scene_load(run->session->context, scene_name, overrides, 2, out);
}

ty_result figure_fld_nebulae(figure_run* run) {
    ty_scene* scene = NULL;
    ty_result result = load(run, run->options->quick ? VOXELS_QUICK : VOXELS, TY_AUTO, &scene);
    if (result == TY_OK) result = fld_show_scene(run, scene, "nebulae", WIDTH, WIDTH);
    ty_scene_destroy(scene);
    figure_caption(run, "The builtin scene nebulae, albedo 0.9, lit from above: an arch with a ball in its shadow, in "
                        "vacuum. Diffusion is solved on a third of the voxels along each side.");
    figure_describe_errors(run, true);
    return result;
}

/* ---- full against half and quarter resolution ---- */

/* Cells of direct light per cell of diffusion. */
static const struct {
    const char* name;
    int ratio;
} grids[GRIDS] = {{"full resolution", 1}, {"half resolution", 2}, {"quarter resolution", 4}};

/* The coarsest is the paper's; ours is finer by default. */
static ty_result compare_grids(figure_run* run, int grid, const figure_picture* picture, const figure_picture* full,
                               plot_cell* cell) {
    ty_difference difference;
    const bool judged = grid == GRIDS - 1 && !run->options->quick;
    ty_result result = ty_image_compare(run->session->context, picture->image, full->image, 1, &difference);
    if (result == TY_OK)
        result = figure_expect(run, grids[grid].name, "relative RMSE", "1", difference.relative_rmse[3],
                               judged ? 0 : NAN, judged ? 0.03 : NAN);
    if (result == TY_OK) result = figure_note(run, grids[grid].name, "mean ratio", "1", difference.mean_ratio[3]);
    if (result == TY_OK) result = figure_error_map(run, picture->image, full->image, 1, &cell->picture);
    if (result != TY_OK) return result;
    snprintf(cell->lines[0], PLOT_LABEL_SIZE, "mean ratio %.4f, relative RMSE %.4f", difference.mean_ratio[3],
             difference.relative_rmse[3]);
    return TY_OK;
}

static ty_result fill_grid(figure_run* run, int grid, const int32_t size[2], figure_picture pictures[GRIDS],
                           plot_sheet* sheet) {
    ty_scene* scene = NULL;
    figure_picture* picture = &pictures[grid];
    plot_cell* cell = plot_sheet_cell(sheet, 0, grid);
    const int voxels = run->options->quick ? VOXELS_QUICK : VOXELS;
    ty_result result = load(run, voxels, grids[grid].ratio, &scene);
    if (result == TY_OK) result = fld_render(run, grids[grid].name, scene, FLD_LIMITED, size, picture);
    if (result == TY_OK)
        result = plot_picture_of_image(run->session->context, picture->image, ty_scene_camera(scene).exposure,
                                       &cell->picture);
    ty_scene_destroy(scene);
    if (result != TY_OK) return result;
    snprintf(sheet->column_titles[grid], PLOT_LABEL_SIZE, "FLD on %d³ cells", voxels / grids[grid].ratio);
    snprintf(cell->lines[0], PLOT_LABEL_SIZE, "%.3g s", picture->seconds);
    return grid == 0 ? TY_OK : compare_grids(run, grid, picture, &pictures[0], plot_sheet_cell(sheet, 1, grid));
}

ty_result figure_fld_resolution(figure_run* run) {
    int32_t size[2];
    plot_sheet sheet;
    figure_picture pictures[GRIDS] = {0};
    figure_view_size(run, WIDTH, WIDTH, size);
    ty_result result = plot_create_sheet(2, GRIDS, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    snprintf(sheet.row_titles[1], PLOT_LABEL_SIZE, "to full resolution");
    for (int grid = 0; grid < GRIDS && result == TY_OK; ++grid) result = fill_grid(run, grid, size, pictures, &sheet);
    figure_place_sheet(run, result, &sheet, &figure_error_scale);
    for (int grid = 0; grid < GRIDS; ++grid) figure_free_picture(&pictures[grid]);
    figure_caption(
        run,
        "The builtin scene nebulae of %d³ voxels. Light that scatters more than once is solved for on as many cells, "
        "and on a half and a quarter of them along each side; light that scatters once is as sharp in all.",
        run->options->quick ? VOXELS_QUICK : VOXELS);
    return result;
}
