/* Figs. 1 and 6 to 9 of the paper: scenes by flux-limited and classical diffusion, against path tracing. */
#include "figures/view.h"

#include <math.h>

enum { LIMITED, CLASSICAL, METHODS, PICTURE_WIDTH = 384 };

static const figure_variant methods[METHODS] = {{.title = "FLD", .method = &ty_method_fld},
                                                {.title = "CDA", .method = &ty_method_cda}};

/* Records the expectation that the error of FLD is below that of CDA. */
static void expect_better(figure_run* run, const char* item, const figure_errors errors[METHODS]) {
    figure_expect(run, item, "mean ratio of FLD", "1", errors[LIMITED].mean_ratio, 1, 0.1);
    figure_expect(run, item, "relative RMSE of FLD over CDA's", "1",
                  errors[LIMITED].relative_rmse / errors[CLASSICAL].relative_rmse, 0, 1);
}

static ty_result show(figure_run* run, const figure_scene* scene) {
    figure_errors errors[METHODS];
    const ty_result result = figure_show_scene(run, scene, methods, METHODS, PICTURE_WIDTH, errors);
    if (result == TY_OK) expect_better(run, scene->title, errors);
    return result;
}

ty_result figure_fld_nebulae(figure_run* run) {
    static const figure_scene scene = {.title = "nebulae",
                                       .scene = "builtin:nebulae",
                                       .overrides = {"media[0].density.noise.resolution=200"},
                                       .quick = "media[0].density.noise.resolution=48",
                                       .width = 256,
                                       .height = 256};
    figure_caption(run, "The builtin scene nebulae, albedo 0.9, lit from above: an arch with a ball in its shadow, in "
                        "vacuum. Diffusion is solved on a third of the voxels along each side.");
    figure_describe_errors(run, true);
    return show(run, &scene);
}

/* Shows a scene of third-party data. */
static ty_result show_volume(figure_run* run, const figure_scene* scene) {
    char path[FIGURE_PATH_SIZE];
    figure_describe_errors(run, true);
    return figure_find_data(run, scene->file, path) ? show(run, scene) : TY_OK;
}

/* Tissue and bone have different albedos, and there is one light, as in the paper. */
ty_result figure_fld_ct(figure_run* run) {
    static const figure_scene scene = {
        .title = "CT head", .scene = "fld_ct_head", .width = 256, .height = 256, .file = CT_HEAD_FILE};
    figure_caption(run, "A head of 64 × 64 × 93 voxels (the paper's is not free), extinction and albedo by transfer "
                        "functions, lit from one side.");
    return show_volume(run, &scene);
}

ty_result figure_fld_fire(figure_run* run) {
    static const figure_scene scene = {
        .title = "plume", .scene = "fld_fire", .width = 216, .height = 288, .file = PLUME_FILE};
    figure_caption(run, "Simulated smoke with an external light that glows as black bodies do (the paper's is not "
                        "free, and has an albedo of 1, with which nothing glows).");
    return show_volume(run, &scene);
}

/* ---- albedos ---- */

/* The exposure makes single scattering as bright in all columns: that of the scene at albedo 0.9, 3.5, and
 * log2(0.9 / albedo) more. */
#define ALBEDO(albedo, exposure)                                                                                       \
    {                                                                                                                  \
        .title = "albedo " #albedo, .scene = "builtin:nebulae",                                                        \
        .overrides = {"media[0].albedo=" #albedo, "camera.exposure=" #exposure,                                        \
                      "media[0].density.noise.resolution=100"},                                                        \
        .quick = "media[0].density.noise.resolution=40", .width = 160, .height = 160                                   \
    }

enum { ALBEDOS = 6, CHARTS = 2 };

ty_result figure_fld_albedo(figure_run* run) {
    static const double albedos[ALBEDOS] = {0.1, 0.3, 0.5, 0.7, 0.9, 1};
    static const figure_scene scenes[ALBEDOS] = {ALBEDO(0.1, 6.67),  ALBEDO(0.3, 5.085), ALBEDO(0.5, 4.348),
                                                 ALBEDO(0.7, 3.863), ALBEDO(0.9, 3.5),   ALBEDO(1, 3.348)};
    static plot_chart charts[CHARTS] = {{.title = "mean over path tracing's", .y_label = "mean ratio"},
                                        {.title = "error to path tracing", .y_label = "relative RMSE"}};
    const figure_variant rows[1 + METHODS] = {figure_path, methods[LIMITED], methods[CLASSICAL]};
    figure_matrix matrix = {.scenes = scenes, .scene_count = ALBEDOS, .variants = rows, .variant_count = 1 + METHODS};
    ty_result result = figure_show_matrix(run, &matrix, 256);
    for (int i = 0; i < ALBEDOS && result == TY_OK; ++i) expect_better(run, scenes[i].title, matrix.errors[i] + 1);
    for (int chart = 0; chart < CHARTS; ++chart) {
        charts[chart].x_label = "albedo";
        charts[chart].series_count = METHODS;
        for (int m = 0; m < METHODS; ++m) {
            plot_series* series = &charts[chart].series[m];
            snprintf(series->name, PLOT_LABEL_SIZE, "%s", methods[m].title);
            for (int i = 0; i < ALBEDOS; ++i) {
                const figure_errors* errors = &matrix.errors[i][1 + m];
                plot_add_point(series, albedos[i], chart == 0 ? errors->mean_ratio : errors->relative_rmse, 0);
            }
        }
    }
    if (result == TY_OK) plot_page_charts(&run->page, charts, CHARTS);
    figure_free_matrix(&matrix);
    figure_caption(run,
                   "The builtin scene nebulae of %d³ voxels, diffusion solved on half of them along each side. Each "
                   "column has an exposure of its own.",
                   run->options->quick ? 40 : 100);
    figure_describe_errors(run, true);
    return result;
}

/* ---- full against half and quarter resolution ---- */

enum { WIDTH = 256, VOXELS = 200, VOXELS_QUICK = 48, GRIDS = 3 };

/* Cells of direct light per cell of diffusion. */
static const struct {
    const char* name;
    int ratio;
} grids[GRIDS] = {{"full resolution", 1}, {"half resolution", 2}, {"quarter resolution", 4}};

/* The coarsest is the paper's; ours is finer by default. */
static ty_result compare_grids(figure_run* run, int grid, const figure_picture* picture, const figure_picture* full,
                               plot_cell* cell) {
    ty_difference difference;
    const bool checked = grid == GRIDS - 1 && !run->options->quick;
    ty_result result = ty_image_compare(run->session->context, picture->image, full->image, 1, &difference);
    if (result == TY_OK)
        figure_expect(run, grids[grid].name, "relative RMSE", "1", difference.relative_rmse[3], checked ? 0 : NAN,
                      checked ? 0.03 : NAN);
    if (result == TY_OK) figure_note(run, grids[grid].name, "mean ratio", "1", difference.mean_ratio[3]);
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
    char coarseness[64], resolution[64];
    const char* const overrides[2] = {coarseness, resolution};
    snprintf(coarseness, sizeof coarseness, "render.fld.ratio=%d", grids[grid].ratio);
    snprintf(resolution, sizeof resolution, "media[0].density.noise.resolution=%d", voxels);
    ty_result result = ty_scene_load(run->session->context, "builtin:nebulae", overrides, 2, &scene);
    if (result == TY_OK)
        result = figure_render_variant(run, grids[grid].name, scene, &methods[LIMITED], size, picture, NULL);
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
