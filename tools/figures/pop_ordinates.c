/* Fig. 14 of the paper: numbers of ordinates, without and with importance sampling for the camera. */
#include "figures/view.h"

enum { COUNTS = 3, WIDTH = 192, PICTURE_WIDTH = 290 };

static const int32_t counts[COUNTS] = {8, 64, 216};
static const char* const choices[2] = {"without importance", "with importance"};

/* Errors of a row and a column. */
typedef struct error_table {
    figure_errors of[2][COUNTS];
} error_table;

static ty_result fill_cell(figure_run* run, ty_scene* scene, int row, int column, const int32_t size[2],
                           const figure_picture* truth, plot_sheet* sheet, figure_errors* errors) {
    char item[FIGURE_NAME_SIZE], options[64];
    const figure_variant variant = {.method = &ty_method_pop, .options = options};
    figure_picture picture = {0};
    snprintf(options, sizeof options, "ordinates=%d importance=%s", (int)counts[column], row == 1 ? "true" : "false");
    snprintf(item, sizeof item, "%d ordinates, %s", (int)counts[column], choices[row]);
    ty_result result = figure_render_variant(run, item, scene, &variant, size, &picture, NULL);
    if (result == TY_OK)
        result = figure_show(run, item, scene, &picture, truth, false, plot_sheet_cell(sheet, row, 1 + column), errors);
    figure_free_picture(&picture);
    return result;
}

static ty_result fill_sheet(figure_run* run, ty_scene* scene, plot_sheet* sheet, error_table* errors) {
    int32_t size[2];
    figure_picture truth = {0};
    figure_view_size(run, WIDTH, WIDTH, size);
    ty_result result = figure_render_variant(run, "path tracing", scene, &figure_path, size, &truth, NULL);
    if (result == TY_OK)
        result = figure_show(run, "path tracing", scene, &truth, NULL, false, plot_sheet_cell(sheet, 0, 0), NULL);
    for (int row = 0; row < 2; ++row)
        for (int column = 0; column < COUNTS && result == TY_OK; ++column)
            result = fill_cell(run, scene, row, column, size, &truth, sheet, &errors->of[row][column]);
    figure_free_picture(&truth);
    return result;
}

/* Criteria: errors decrease with the number of ordinates, and importance helps for few of them. */
static ty_result expect_errors(figure_run* run, const error_table* errors) {
    figure_expect(run, "216 ordinates over 8", "relative RMSE", "1",
                  errors->of[1][COUNTS - 1].relative_rmse / errors->of[1][0].relative_rmse, 0, 1);
    figure_expect(run, "8 ordinates, importance over none", "relative RMSE", "1",
                  errors->of[1][0].relative_rmse / errors->of[0][0].relative_rmse, 0, 1);
    return TY_OK;
}

static void show_chart(figure_run* run, plot_chart* chart, const error_table* errors) {
    *chart = (plot_chart){.title = "error to path tracing",
                          .x_label = "ordinates",
                          .y_label = "relative RMSE",
                          .x_logarithmic = true,
                          .y_logarithmic = true,
                          .series_count = 2};
    for (int row = 0; row < 2; ++row) {
        snprintf(chart->series[row].name, PLOT_LABEL_SIZE, "%s", choices[row]);
        for (int i = 0; i < COUNTS; ++i)
            plot_add_point(&chart->series[row], counts[i], errors->of[row][i].relative_rmse, 0);
    }
    plot_page_charts(&run->page, chart, 1);
}

ty_result figure_pop_ordinates(figure_run* run) {
    static const figure_scene from = {.scene = "pop_smoke", .windows = true};
    static plot_chart chart;
    ty_scene* scene = NULL;
    plot_sheet sheet;
    error_table errors = {0};
    ty_result result = plot_create_sheet(2, 1 + COUNTS, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    result = figure_load(run, &from, &scene);
    if (result == TY_OK) result = fill_sheet(run, scene, &sheet, &errors);
    if (result == TY_OK) result = expect_errors(run, &errors);
    if (result == TY_OK) {
        snprintf(sheet.column_titles[0], PLOT_LABEL_SIZE, "path tracing");
        for (int i = 0; i < COUNTS; ++i)
            snprintf(sheet.column_titles[1 + i], PLOT_LABEL_SIZE, "%d ordinates", (int)counts[i]);
        for (int row = 0; row < 2; ++row) snprintf(sheet.row_titles[row], PLOT_LABEL_SIZE, "%s", choices[row]);
        plot_page_sheet(&run->page, &sheet);
        show_chart(run, &chart, &errors);
    }
    ty_scene_destroy(scene);
    plot_free_sheet(&sheet);
    figure_caption(run, "Smoke of noise, σs = {2.9, 3.6, 4.2}/m, σa = {3.4, 3.35, 3.4}/m, g = 0.9, 2 m across, in a "
                        "room with windows and a lamp; ordinates of 20³ cells.");
    figure_describe_errors(run, true);
    return result;
}
