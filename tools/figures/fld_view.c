/* Rendering and comparison of flux-limited and classical diffusion. */
#include "figures/fld_view.h"

enum { PICTURE_WIDTH = 384 };

const char* const fld_method_titles[FLD_METHODS] = {"path tracing", "FLD", "CDA"};

ty_result fld_render(figure_run* run, const char* item, const ty_scene* scene, fld_method method, const int32_t size[2],
                     figure_picture* out) {
    static const ty_method* const methods[FLD_METHODS] = {&ty_method_path, &ty_method_fld, &ty_method_cda};
    cli_report report;
    ty_result result = figure_render(run, item, scene, methods[method], size, out, &report);
    if (result != TY_OK || method == FLD_PATH) return result;
    const ty_fld_stats* fld = (const ty_fld_stats*)report.run.stats;
    result = figure_note(run, item, "time of the solve", "s", fld->solve_seconds);
    return result == TY_OK ? figure_expect(run, item, "converged", "1", fld->converged ? 1 : 0, 1, 0) : result;
}

ty_result fld_expect_better(figure_run* run, const char* item, const figure_errors* limited,
                            const figure_errors* classical) {
    const ty_result result = figure_expect(run, item, "mean ratio of FLD", "1", limited->mean_ratio, 1, 0.1);
    if (result != TY_OK) return result;
    return figure_expect(run, item, "relative RMSE of FLD over CDA's", "1",
                         limited->relative_rmse / classical->relative_rmse, 0, 1);
}

/* ---- a page of one scene ---- */

typedef struct scene_page {
    plot_sheet sheet;
    plot_table table;
} scene_page;

static ty_result begin_page(scene_page* page) {
    static const char* const heads[] = {"",           "time",          "1000 paths a pixel",
                                        "mean ratio", "relative RMSE", "relMSE, with noise"};
    enum { COLUMNS = sizeof heads / sizeof heads[0] };
    *page = (scene_page){0};
    ty_result result = plot_create_sheet(2, FLD_METHODS, PICTURE_WIDTH, &page->sheet);
    if (result == TY_OK) result = plot_create_table(1 + FLD_METHODS, COLUMNS, 1, &page->table);
    if (result != TY_OK) return result;
    for (int column = 0; column < COLUMNS; ++column) plot_set_cell(&page->table, 0, column, "%s", heads[column]);
    for (int method = 0; method < FLD_METHODS; ++method) {
        snprintf(page->sheet.column_titles[method], PLOT_LABEL_SIZE, "%s", fld_method_titles[method]);
        plot_set_cell(&page->table, 1 + method, 0, "%s", fld_method_titles[method]);
    }
    snprintf(page->sheet.row_titles[1], PLOT_LABEL_SIZE, "errors");
    return TY_OK;
}

static void end_page(scene_page* page) {
    plot_free_sheet(&page->sheet);
    plot_free_table(&page->table);
}

static void set_row(plot_table* table, fld_method method, const figure_picture* picture, const figure_picture* truth,
                    const figure_errors* errors) {
    const double paper = figure_paper_seconds(truth);
    plot_set_cell(table, 1 + method, 1, "%.3g s", picture->seconds);
    if (method == FLD_PATH) {
        plot_set_cell(table, 1 + method, 2, "%.3g s", paper);
        return;
    }
    plot_set_cell(table, 1 + method, 2, "%.0f times faster", paper / picture->seconds);
    plot_set_cell(table, 1 + method, 3, "%.3f", errors->mean_ratio);
    plot_set_cell(table, 1 + method, 4, "%.3f", errors->relative_rmse);
    plot_set_cell(table, 1 + method, 5, "%.3f", errors->rel_mse);
}

static ty_result show_method(figure_run* run, const ty_scene* scene, const char* item, fld_method method,
                             const figure_picture* picture, const figure_picture* truth, scene_page* page,
                             figure_errors* errors) {
    ty_context* context = run->session->context;
    plot_cell *cell = plot_sheet_cell(&page->sheet, 0, method), *map = plot_sheet_cell(&page->sheet, 1, method);
    ty_result result = plot_picture_of_image(context, picture->image, ty_scene_camera(scene).exposure, &cell->picture);
    if (result == TY_OK && method != FLD_PATH) result = figure_compare(run, item, picture, truth, errors);
    if (result == TY_OK && method != FLD_PATH)
        result = figure_error_map(run, picture->image, truth->image, figure_block(truth->image), &map->picture);
    if (result == TY_OK) set_row(&page->table, method, picture, truth, errors);
    return result;
}

static ty_result fill_page(figure_run* run, const ty_scene* scene, const char* item, const int32_t size[2],
                           scene_page* page) {
    figure_picture pictures[FLD_METHODS] = {0};
    figure_errors errors[FLD_METHODS] = {0};
    ty_result result = TY_OK;
    for (fld_method method = 0; method < FLD_METHODS && result == TY_OK; ++method) {
        char own[FIGURE_NAME_SIZE];
        snprintf(own, sizeof own, "%s, %s", item, fld_method_titles[method]);
        result = fld_render(run, own, scene, method, size, &pictures[method]);
        if (result == TY_OK)
            result =
                show_method(run, scene, own, method, &pictures[method], &pictures[FLD_PATH], page, &errors[method]);
    }
    if (result == TY_OK) result = fld_expect_better(run, item, &errors[FLD_LIMITED], &errors[FLD_CLASSICAL]);
    for (int method = 0; method < FLD_METHODS; ++method) figure_free_picture(&pictures[method]);
    return result;
}

ty_result fld_show_scene(figure_run* run, const ty_scene* scene, const char* item, int32_t width, int32_t height) {
    int32_t size[2];
    scene_page page;
    figure_view_size(run, width, height, size);
    ty_result result = begin_page(&page);
    if (result == TY_OK) result = fill_page(run, scene, item, size, &page);
    if (result == TY_OK) {
        plot_page_sheet(&run->page, &page.sheet);
        plot_page_color_bar(&run->page, &figure_error_scale);
        plot_page_table(&run->page, &page.table);
    }
    end_page(&page);
    return result;
}
