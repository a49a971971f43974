/* Fig. 15 of the paper: clouds with strong forward scattering. */
#include "figures/pop_view.h"

#include <string.h>

enum { COSINES = 2, ROWS = 3, WIDTH = 256, PICTURE_WIDTH = 384 };

static const double cosines[COSINES] = {0.96, 0};
static const char* const row_titles[ROWS] = {"path tracing", "split", "FLD"};
static const char* const column_titles[COSINES] = {"g = 0.96", "isotropic"};

static ty_result fill_cell(figure_run* run, const char* item, ty_scene* scene, int row, const int32_t size[2],
                           figure_picture pictures[ROWS], plot_cell* cell, figure_errors* errors) {
    cli_report report;
    const ty_pop_def settings = pop_scene_def(scene);
    ty_result result = row == 2 ? figure_render(run, item, scene, &ty_method_fld, size, &pictures[row], &report)
                                : pop_render(run, item, scene, row == 1 ? &settings : NULL, size, &pictures[row], NULL);
    if (result != TY_OK) return result;
    return figure_show(run, item, scene, &pictures[row], row > 0 ? &pictures[0] : NULL, false, cell, errors);
}

static ty_result fill_column(figure_run* run, int column, plot_sheet* sheet) {
    int32_t size[2];
    char override[32];
    const char* const overrides[1] = {override};
    ty_scene* scene = NULL;
    figure_picture pictures[ROWS] = {0};
    figure_errors errors[ROWS] = {0};
    figure_view_size(run, WIDTH, WIDTH, size);
    snprintf(override, sizeof override, "media[0].g=%g", cosines[column]);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "%s", column_titles[column]);
    ty_result result = figure_load_scene(run, "pop_cloud", overrides, 1, &scene);
    for (int row = 0; row < ROWS && result == TY_OK; ++row) {
        char item[FIGURE_NAME_SIZE];
        snprintf(item, sizeof item, "%s, %s", column_titles[column], row_titles[row]);
        result = fill_cell(run, item, scene, row, size, pictures, plot_sheet_cell(sheet, row, column), &errors[row]);
    }
    if (result == TY_OK)
        result = figure_expect(run, column_titles[column], "mean ratio of split", "1", errors[1].mean_ratio, 1, 0.1);
    if (result == TY_OK && cosines[column] >= 0.7)
        result = figure_expect(run, column_titles[column], "relative RMSE of split over FLD's", "1",
                               errors[1].relative_rmse / errors[2].relative_rmse, 0, 1);
    for (int row = 0; row < ROWS; ++row) figure_free_picture(&pictures[row]);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_pop_clouds(figure_run* run) {
    plot_sheet sheet;
    ty_result result = plot_create_sheet(ROWS, COSINES, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    for (int row = 0; row < ROWS; ++row) snprintf(sheet.row_titles[row], PLOT_LABEL_SIZE, "%s", row_titles[row]);
    for (int column = 0; column < COSINES && result == TY_OK; ++column) result = fill_column(run, column, &sheet);
    figure_place_sheet(run, result, &sheet, NULL);
    figure_caption(run, "A cloud of noise, 96³ voxels, σt = 60/m, albedo 0.999, against a low sun behind it; 64 "
                        "ordinates of 20³ cells for the sky, the sun through cells as fine as the voxels.");
    figure_describe_errors(run, true);
    return result;
}
