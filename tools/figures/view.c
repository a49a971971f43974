/* Rendering and comparison of methods. */
#include "figures/view.h"

#include <math.h>
#include <string.h>

enum { SAMPLES = 64, SAMPLES_QUICK = 4, PAPER_SAMPLES = 1000 };

void figure_view_size(const figure_run* run, int32_t width, int32_t height, int32_t size[2]) {
    const figure_options* options = run->options;
    const int32_t divisor = options->quick ? 4 : 1;
    size[0] = options->size[0] > 0 ? options->size[0] : width / divisor;
    size[1] = options->size[0] > 0 ? options->size[1] : height / divisor;
}

void figure_free_picture(figure_picture* picture) {
    ty_image_destroy(picture->image);
    picture->image = NULL;
}

ty_result figure_render(figure_run* run, const char* item, const ty_scene* scene, const ty_method* method,
                        const int32_t size[2], figure_picture* out, cli_report* report) {
    const cli_request request = {.spp = figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES),
                                 .seed = run->session->common.seed,
                                 .width = size[0],
                                 .height = size[1],
                                 .aovs = method == &ty_method_path ? TY_AOV_VARIANCE : 0};
    figure_picture picture = {.samples = request.spp};
    *report = (cli_report){0};
    ty_result result = cli_render_method(run->session, scene, method, &request, &picture.image, report);
    picture.seconds = report->run.own_seconds;
    if (result == TY_OK) result = figure_note(run, item, "time", "s", picture.seconds);
    if (result == TY_OK)
        *out = picture;
    else
        figure_free_picture(&picture);
    return result;
}

int32_t figure_block(const ty_image* image) {
    return ty_image_width(image) < FIGURE_BLOCK || ty_image_height(image) < FIGURE_BLOCK ? 1 : FIGURE_BLOCK;
}

double figure_paper_seconds(const figure_picture* truth) {
    return truth->seconds * PAPER_SAMPLES / truth->samples;
}

ty_result figure_compare(figure_run* run, const char* item, const figure_picture* picture, const figure_picture* truth,
                         figure_errors* out) {
    ty_difference difference;
    double noise[4];
    const int32_t block = figure_block(truth->image);
    ty_result result = ty_image_compare(run->session->context, picture->image, truth->image, block, &difference);
    if (result != TY_OK) return result;
    bench_noise(truth->image, block, noise);
    const double mean = difference.rmse[3] / difference.relative_rmse[3];
    out->mean_ratio = difference.mean_ratio[3];
    out->rel_mse = difference.rel_mse[3];
    out->relative_rmse = bench_without_noise(difference.rmse[3], noise[3]) / mean;
    result = figure_note(run, item, "mean ratio", "1", out->mean_ratio);
    if (result == TY_OK) result = figure_note(run, item, "relative RMSE", "1", out->relative_rmse);
    if (result == TY_OK) result = figure_note(run, item, "relMSE, with noise", "1", out->rel_mse);
    if (result != TY_OK) return result;
    return figure_note(run, item, "times faster than 1000 paths a pixel", "1",
                       figure_paper_seconds(truth) / picture->seconds);
}

void figure_format_error(double error, char out[16]) {
    snprintf(out, 16, isnan(error) ? "< noise" : "%.3f", error);
}

ty_result figure_show(figure_run* run, const char* item, const ty_scene* scene, const figure_picture* picture,
                      const figure_picture* truth, bool level, plot_cell* cell, figure_errors* errors) {
    figure_errors own = {.mean_ratio = 1};
    double exposure = ty_scene_camera(scene).exposure;
    ty_result result = truth != NULL ? figure_compare(run, item, picture, truth, &own) : TY_OK;
    if (level) exposure -= log2(own.mean_ratio);
    if (result == TY_OK)
        result = plot_picture_of_image(run->session->context, picture->image, exposure, &cell->picture);
    if (result != TY_OK) return result;
    snprintf(cell->lines[0], PLOT_LABEL_SIZE, "%.3g s%s", picture->seconds, level ? "; made as bright" : "");
    if (truth == NULL) return TY_OK;
    char error[16];
    figure_format_error(own.relative_rmse, error);
    snprintf(cell->lines[1], PLOT_LABEL_SIZE, "mean ratio %.3f, rel. RMSE %s", own.mean_ratio, error);
    if (errors != NULL) *errors = own;
    return TY_OK;
}

/* ---- sheets ---- */

void figure_describe_errors(figure_run* run, bool without_noise) {
    const size_t used = strlen(run->caption);
    snprintf(run->caption + used, sizeof run->caption - used, " Errors are of means over %d × %d pixels%s.",
             FIGURE_BLOCK, FIGURE_BLOCK, without_noise ? ", the relative RMSE without the truth's own noise" : "");
}

ty_result figure_render_by_method(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2],
                                  const void* user, figure_picture* out) {
    cli_report report;
    return figure_render(run, item, scene, user, size, out, &report);
}

/* One column. truth NULL: the column is the reference itself. */
static ty_result show_variant(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variant,
                              int column, const int32_t size[2], const figure_picture* truth, plot_sheet* sheet,
                              figure_picture* picture, figure_errors* errors) {
    char own[FIGURE_NAME_SIZE];
    snprintf(own, sizeof own, "%s, %s", item, variant->title);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "%s", variant->title);
    ty_result result = variant->render(run, own, scene, size, variant->user, picture);
    if (result == TY_OK)
        result = figure_show(run, own, scene, picture, truth, false, plot_sheet_cell(sheet, 0, column), errors);
    if (result != TY_OK || truth == NULL) return result;
    return figure_error_map(run, picture->image, truth->image, figure_block(truth->image),
                            &plot_sheet_cell(sheet, 1, column)->picture);
}

ty_result figure_show_variants(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variants,
                               int count, const int32_t size[2], double picture_width, figure_errors* errors) {
    static const figure_variant path = {"path tracing", figure_render_by_method, &ty_method_path};
    plot_sheet sheet;
    figure_picture truth = {0};
    ty_result result = plot_create_sheet(2, 1 + count, picture_width, &sheet);
    if (result != TY_OK) return result;
    snprintf(sheet.row_titles[1], PLOT_LABEL_SIZE, "errors");
    result = show_variant(run, item, scene, &path, 0, size, NULL, &sheet, &truth, NULL);
    for (int i = 0; i < count && result == TY_OK; ++i) {
        figure_picture picture = {0};
        result = show_variant(run, item, scene, &variants[i], 1 + i, size, &truth, &sheet, &picture, &errors[i]);
        figure_free_picture(&picture);
    }
    figure_place_sheet(run, result, &sheet, &figure_error_scale);
    figure_free_picture(&truth);
    return result;
}
