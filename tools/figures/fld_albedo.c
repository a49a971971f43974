/* Fig. 7 of the paper: the nebula with albedos from 0.1 to 1. */
#include "figures/fld_view.h"

#include <math.h>
#include <stdlib.h>

enum { ALBEDOS = 6, WIDTH = 160, VOXELS = 100, VOXELS_QUICK = 40, PICTURE_WIDTH = 256 };

static const double albedos[ALBEDOS] = {0.1, 0.3, 0.5, 0.7, 0.9, 1};

/* Mean ratio, relative RMSE. */
enum { CHARTS = 2 };

/* Single scattering is normalized to equal brightness in all columns. */
static double exposure_of(const ty_scene* scene, double albedo) {
    return ty_scene_camera(scene).exposure + log2(0.9 / albedo);
}

static ty_result load(figure_run* run, int column, ty_scene** out) {
    char albedo[48], resolution[64];
    const char* const overrides[2] = {albedo, resolution};
    snprintf(albedo, sizeof albedo, "media[0].albedo=%g", albedos[column]);
    snprintf(resolution, sizeof resolution, "media[0].density.noise.resolution=%d",
             run->options->quick ? VOXELS_QUICK : VOXELS);
    return ty_scene_load(run->session->context, "builtin:nebulae", overrides, 2, out);
}

static ty_result fill_method(figure_run* run, const ty_scene* scene, int column, fld_method method,
                             const int32_t size[2], figure_picture* picture, const figure_picture* truth,
                             plot_sheet* sheet, plot_chart charts[CHARTS], figure_errors* errors) {
    char item[FIGURE_NAME_SIZE];
    plot_cell* cell = plot_sheet_cell(sheet, method, column);
    snprintf(item, sizeof item, "albedo %g, %s", albedos[column], fld_method_titles[method]);
    ty_result result = fld_render(run, item, scene, method, size, picture);
    if (result == TY_OK)
        result = plot_picture_of_image(run->session->context, picture->image, exposure_of(scene, albedos[column]),
                                       &cell->picture);
    if (result != TY_OK || method == FLD_PATH) return result;
    result = figure_compare(run, item, picture, truth, errors);
    snprintf(cell->lines[0], PLOT_LABEL_SIZE, "mean ratio %.3f, rel. RMSE %.3f", errors->mean_ratio,
             errors->relative_rmse);
    plot_add_point(&charts[0].series[method - 1], albedos[column], errors->mean_ratio, 0);
    plot_add_point(&charts[1].series[method - 1], albedos[column], errors->relative_rmse, 0);
    return result;
}

static ty_result fill_column(figure_run* run, int column, plot_sheet* sheet, plot_chart charts[CHARTS]) {
    int32_t size[2];
    ty_scene* scene = NULL;
    figure_picture pictures[FLD_METHODS] = {0};
    figure_errors errors[FLD_METHODS] = {0};
    char item[FIGURE_NAME_SIZE];
    figure_view_size(run, WIDTH, WIDTH, size);
    ty_result result = load(run, column, &scene);
    for (fld_method method = 0; method < FLD_METHODS && result == TY_OK; ++method)
        result = fill_method(run, scene, column, method, size, &pictures[method], &pictures[FLD_PATH], sheet, charts,
                             &errors[method]);
    snprintf(item, sizeof item, "albedo %g", albedos[column]);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "%s", item);
    if (result == TY_OK) result = fld_expect_better(run, item, &errors[FLD_LIMITED], &errors[FLD_CLASSICAL]);
    for (int method = 0; method < FLD_METHODS; ++method) figure_free_picture(&pictures[method]);
    ty_scene_destroy(scene);
    return result;
}

static void begin_charts(plot_chart charts[CHARTS]) {
    charts[0].title = "mean over path tracing's";
    charts[0].y_label = "mean ratio";
    charts[1].title = "error to path tracing";
    charts[1].y_label = "relative RMSE";
    for (int chart = 0; chart < CHARTS; ++chart) {
        charts[chart].x_label = "albedo";
        charts[chart].series_count = FLD_METHODS - 1;
        for (int method = 1; method < FLD_METHODS; ++method)
            snprintf(charts[chart].series[method - 1].name, PLOT_LABEL_SIZE, "%s", fld_method_titles[method]);
    }
}

ty_result figure_fld_albedo(figure_run* run) {
    plot_sheet sheet = {0};
    plot_chart* charts = calloc(CHARTS, sizeof *charts);
    ty_result result =
        charts != NULL ? plot_create_sheet(FLD_METHODS, ALBEDOS, PICTURE_WIDTH, &sheet) : TY_ERROR_MEMORY;
    if (result == TY_OK) begin_charts(charts);
    for (int column = 0; column < ALBEDOS && result == TY_OK; ++column)
        result = fill_column(run, column, &sheet, charts);
    if (result == TY_OK) {
        for (int method = 0; method < FLD_METHODS; ++method)
            snprintf(sheet.row_titles[method], PLOT_LABEL_SIZE, "%s", fld_method_titles[method]);
        plot_page_sheet(&run->page, &sheet);
        plot_page_charts(&run->page, charts, CHARTS);
    }
    plot_free_sheet(&sheet);
    free(charts);
    figure_caption(run,
                   "The builtin scene nebulae of %d³ voxels, diffusion solved on half of them along each side. Each "
                   "column has an exposure of its own.",
                   run->options->quick ? VOXELS_QUICK : VOXELS);
    figure_describe_errors(run, true);
    return result;
}
