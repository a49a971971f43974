/* Rendering by the methods that figures compare, and comparing them. */
#include "cli/figures/fld_view.h"

#include "cli/methods.h"

#include <math.h>

enum { SAMPLES = 64, SAMPLES_QUICK = 4, PAPER_SAMPLES = 1000, PICTURE_WIDTH = 384 };

const char* const fld_method_titles[FLD_METHODS] = {"path tracing", "FLD", "CDA"};

void fld_view_size(const figure_run* run, int32_t width, int32_t height, int32_t size[2]) {
    const figure_options* options = run->options;
    const int32_t part = options->quick ? 4 : 1;
    size[0] = options->size[0] > 0 ? options->size[0] : width / part;
    size[1] = options->size[0] > 0 ? options->size[1] : height / part;
}

void fld_free_picture(fld_picture* picture) {
    ty_image_destroy(picture->image);
    picture->image = NULL;
}

ty_result fld_render(figure_run* run, const char* item, const ty_scene* scene, fld_method method, const int32_t size[2],
                     fld_picture* out) {
    static const cli_method* const methods[FLD_METHODS] = {&cli_method_path, &cli_method_fld, &cli_method_cda};
    const cli_request request = {.spp = figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES),
                                 .seed = run->session->common.seed,
                                 .width = size[0],
                                 .height = size[1],
                                 .aovs = method == FLD_PATH ? TY_AOV_VARIANCE : 0};
    cli_report report = {0};
    fld_picture picture = {.samples = request.spp};
    ty_result result = methods[method]->render(run->session, scene, &request, &picture.image, &report);
    picture.seconds = report.own_seconds;
    if (result == TY_OK) result = figure_note(run, item, "time", "s", picture.seconds);
    if (result == TY_OK && method != FLD_PATH)
        result = figure_note(run, item, "time of the solve", "s", report.fld.solve_seconds);
    if (result == TY_OK && method != FLD_PATH)
        result = figure_expect(run, item, "converged", "1", report.fld.converged ? 1 : 0, 1, 0);
    if (result == TY_OK)
        *out = picture;
    else
        fld_free_picture(&picture);
    return result;
}

/* Blocks that a picture of this size has. */
static int32_t block_of(const ty_image* image) {
    return ty_image_width(image) < FLD_BLOCK || ty_image_height(image) < FLD_BLOCK ? 1 : FLD_BLOCK;
}

ty_result fld_compare(figure_run* run, const char* item, const fld_picture* picture, const fld_picture* truth,
                      fld_errors* out) {
    ty_difference difference;
    double noise[4];
    const int32_t block = block_of(truth->image);
    ty_result result = ty_image_compare(run->session->context, picture->image, truth->image, block, &difference);
    if (result != TY_OK) return result;
    figure_noise(truth->image, block, noise);
    const double mean = difference.rmse[3] / difference.relative_rmse[3];
    out->mean_ratio = difference.mean_ratio[3];
    out->rel_mse = difference.rel_mse[3];
    out->relative_rmse = figure_without_noise(difference.rmse[3], noise[3]) / mean;
    result = figure_note(run, item, "mean ratio", "1", out->mean_ratio);
    if (result == TY_OK) result = figure_note(run, item, "relative RMSE", "1", out->relative_rmse);
    if (result == TY_OK) result = figure_note(run, item, "relMSE, with noise", "1", out->rel_mse);
    if (result != TY_OK) return result;
    const double paper = truth->seconds * PAPER_SAMPLES / truth->samples;
    return figure_note(run, item, "times faster than 1000 paths a pixel", "1", paper / picture->seconds);
}

ty_result fld_expect_better(figure_run* run, const char* item, const fld_errors* limited, const fld_errors* classical) {
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

static void set_row(plot_table* table, fld_method method, const fld_picture* picture, const fld_picture* truth,
                    const fld_errors* errors) {
    const double paper = truth->seconds * PAPER_SAMPLES / truth->samples;
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
                             const fld_picture* picture, const fld_picture* truth, scene_page* page,
                             fld_errors* errors) {
    ty_context* context = run->session->context;
    plot_cell *cell = plot_sheet_cell(&page->sheet, 0, method), *map = plot_sheet_cell(&page->sheet, 1, method);
    ty_result result = plot_picture_of_image(context, picture->image, ty_scene_camera(scene).exposure, &cell->picture);
    if (result == TY_OK && method != FLD_PATH) result = fld_compare(run, item, picture, truth, errors);
    if (result == TY_OK && method != FLD_PATH)
        result = figure_error_map(run, picture->image, truth->image, block_of(truth->image), &map->picture);
    if (result == TY_OK) set_row(&page->table, method, picture, truth, errors);
    return result;
}

static ty_result fill_page(figure_run* run, const ty_scene* scene, const char* item, const int32_t size[2],
                           scene_page* page) {
    fld_picture pictures[FLD_METHODS] = {0};
    fld_errors errors[FLD_METHODS] = {0};
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
    for (int method = 0; method < FLD_METHODS; ++method) fld_free_picture(&pictures[method]);
    return result;
}

ty_result fld_show_scene(figure_run* run, const ty_scene* scene, const char* item, int32_t width, int32_t height) {
    int32_t size[2];
    scene_page page;
    fld_view_size(run, width, height, size);
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
