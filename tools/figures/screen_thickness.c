/* Fig. 7 of the paper: optical thickness 2, 4, 6 and 8, against the screen-space reference. */
#include "figures/screen_view.h"

enum { THICKNESSES = 4, METHODS = 3, SHOWN = 2, ROOM_WIDTH = 288, PAGE_WIDTH = 1900 };

static const screen_water waters[THICKNESSES] = {{2, 0.97f}, {4, 0.97f}, {6, 0.97f}, {8, 0.97f}};
static const char* const names[METHODS] = {"scatter", "gather", "naive"};

/* All variants use the reference's spread. */
static void choose_method(int method, ty_screen_def* def) {
    def->spread = TY_SCREEN_SPREAD_GAUSSIAN;
    if (method == 1) def->variant = TY_SCREEN_GATHER;
    if (method == 2) ty_screen_naive_def(def);
}

/* The charts: relative RMSE and relMSE, one series per method. */
typedef struct error_charts {
    plot_chart relative_rmse, rel_mse;
} error_charts;

static error_charts begin_charts(void) {
    error_charts charts = {{.title = "relative RMSE", .y_label = "RMSE / mean"},
                           {.title = "relMSE", .y_label = "mean of relative error²", .y_logarithmic = true}};
    plot_chart* both[2] = {&charts.relative_rmse, &charts.rel_mse};
    for (int i = 0; i < 2; ++i) {
        both[i]->x_label = "optical thickness of scattering, back wall";
        both[i]->series_count = METHODS;
        for (int method = 0; method < METHODS; ++method)
            snprintf(both[i]->series[method].name, PLOT_LABEL_SIZE, "%s", names[method]);
    }
    return charts;
}

/* An image and its error map below; rows are methods and errors, columns thicknesses. */
static ty_result show_method(figure_run* run, const screen_view* view, int column, int method, const ty_image* image,
                             const ty_image* reference, plot_sheet* sheet) {
    plot_cell *cell = plot_sheet_cell(sheet, 1 + 2 * method, column),
              *errors = plot_sheet_cell(sheet, 2 + 2 * method, column);
    const ty_result result = plot_picture_of_image(run->session->context, image, view->camera.exposure, &cell->picture);
    return result == TY_OK ? figure_error_map(run, image, reference, 1, &errors->picture) : result;
}

static ty_result fill_method(figure_run* run, const screen_view* view, int column, int method,
                             const ty_image* reference, plot_sheet* sheet, error_charts* charts) {
    ty_screen_def def = screen_room_def(view, &waters[column]);
    choose_method(method, &def);
    char item[FIGURE_NAME_SIZE];
    snprintf(item, sizeof item, "%s, thickness %g", names[method], waters[column].thickness);
    ty_image* image = NULL;
    ty_screen_stats stats = ty_default_screen_stats();
    ty_difference difference;
    ty_result result = screen_apply(run, view, &def, &image, &stats);
    if (result == TY_OK) result = figure_note_difference(run, item, image, reference, &difference);
    if (result == TY_OK) figure_note(run, item, "pixels cut to the pyramid", "pixel", (double)stats.oversized);
    if (result == TY_OK && method < SHOWN) result = show_method(run, view, column, method, image, reference, sheet);
    ty_image_destroy(image);
    if (result != TY_OK) return result;
    if (method < SHOWN)
        snprintf(plot_sheet_cell(sheet, 2 + 2 * method, column)->lines[0], PLOT_LABEL_SIZE,
                 "RMSE %.3g, relative %.3g, relMSE %.2g", difference.rmse[3], difference.relative_rmse[3],
                 difference.rel_mse[3]);
    plot_add_point(&charts->relative_rmse.series[method], waters[column].thickness, difference.relative_rmse[3], 0);
    plot_add_point(&charts->rel_mse.series[method], waters[column].thickness, difference.rel_mse[3], 0);
    return TY_OK;
}

static ty_result fill_column(figure_run* run, const screen_view* view, int column, plot_sheet* sheet,
                             error_charts* charts) {
    ty_screen_def def = screen_room_def(view, &waters[column]);
    def.variant = TY_SCREEN_REFERENCE;
    ty_image* reference = NULL;
    ty_screen_stats stats = ty_default_screen_stats();
    plot_cell* cell = plot_sheet_cell(sheet, 0, column);
    ty_result result = screen_apply(run, view, &def, &reference, &stats);
    if (result == TY_OK)
        result = plot_picture_of_image(run->session->context, reference, view->camera.exposure, &cell->picture);
    for (int method = 0; method < METHODS && result == TY_OK; ++method)
        result = fill_method(run, view, column, method, reference, sheet, charts);
    ty_image_destroy(reference);
    if (result != TY_OK) return result;
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "τ = %g, half the light within %.0f pixels",
             waters[column].thickness, stats.spread);
    return TY_OK;
}

static void place_on_page(figure_run* run, plot_sheet* sheet, const error_charts* charts) {
    snprintf(sheet->row_titles[0], PLOT_LABEL_SIZE, "reference");
    for (int method = 0; method < SHOWN; ++method) {
        snprintf(sheet->row_titles[1 + 2 * method], PLOT_LABEL_SIZE, "%s", names[method]);
        snprintf(sheet->row_titles[2 + 2 * method], PLOT_LABEL_SIZE, "error of %s", names[method]);
    }
    plot_page_sheet(&run->page, sheet);
    plot_page_color_bar(&run->page, &figure_error_scale);
    const plot_chart both[2] = {charts->relative_rmse, charts->rel_mse};
    plot_page_charts(&run->page, both, 2);
}

ty_result figure_screen_thickness(figure_run* run) {
    int32_t size[2];
    screen_view view = {0};
    plot_sheet sheet = {0};
    error_charts charts = begin_charts();
    screen_room_size(run, ROOM_WIDTH, size);
    ty_result result = screen_render_room(run, size, &view);
    if (result == TY_OK)
        result = plot_create_sheet(1 + 2 * SHOWN, THICKNESSES, (PAGE_WIDTH - 60) / THICKNESSES, &sheet);
    for (int column = 0; column < THICKNESSES && result == TY_OK; ++column)
        result = fill_column(run, &view, column, &sheet, &charts);
    if (result == TY_OK) place_on_page(run, &sheet, &charts);
    plot_free_sheet(&sheet);
    screen_free_view(&view);
    figure_caption(run,
                   "The builtin scene screen_room, %d × %d pixels, g = %g, scattering of optical thickness τ as far as "
                   "the back wall (%g m). The spread is the paper's Gaussian, also of scatter. Errors are against the "
                   "unbounded screen-space reference, RMSE in W m⁻² sr⁻¹.",
                   size[0], size[1], (double)waters[0].g, SCREEN_ROOM_DEPTH);
    return result;
}
