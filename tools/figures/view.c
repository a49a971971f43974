/* Rendering and comparison of methods. */
#include "figures/view.h"

#include "figures/windows.h"
#include "option/option.h"

#include <math.h>
#include <string.h>

enum { SAMPLES = 64, SAMPLES_QUICK = 4, PAPER_SAMPLES = 1000, FIGURE_DEF_SIZE = 1024 };

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
    if (result == TY_OK) figure_note(run, item, "time", "s", picture.seconds);
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
    figure_notes(run, item, {"mean ratio", "1", out->mean_ratio}, {"relative RMSE", "1", out->relative_rmse},
                 {"relMSE, with noise", "1", out->rel_mse});
    if (result != TY_OK) return result;
    figure_note(run, item, "times faster than 1000 paths a pixel", "1", figure_paper_seconds(truth) / picture->seconds);
    return TY_OK;
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

double figure_mean(const ty_image* image) {
    const size_t count = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    const float* planes[3];
    double sum = 0;
    if (!ty_image_rgb_planes(image, planes)) return NAN;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < count; ++i) sum += (double)planes[c][i];
    return sum / (3.0 * (double)count);
}

/* ---- tables of scenes and variants ---- */

const figure_variant figure_path = {.title = "path tracing", .method = &ty_method_path};

ty_result figure_load(figure_run* run, const figure_scene* from, ty_scene** out) {
    const char* overrides[FIGURE_OVERRIDES_MAX + 1];
    int32_t count = 0;
    while (count < FIGURE_OVERRIDES_MAX && from->overrides[count] != NULL) {
        overrides[count] = from->overrides[count];
        ++count;
    }
    if (from->quick != NULL && run->options->quick) overrides[count++] = from->quick;
    const ty_result result = figure_load_scene(run, from->scene, overrides, count, out);
    return result == TY_OK && from->windows ? figure_add_windows(*out) : result;
}

ty_result figure_method_def(const ty_scene* scene, const ty_method* method, const char* options, void* def) {
    char key[32], value[32];
    const char* at = options != NULL ? options : "";
    ty_options_init(method->options, def, method->options->bytes);
    ty_result result = ty_method_options(scene, method->options->name, def);
    for (int length = 0; result == TY_OK && *at != '\0'; at += length) {
        if (sscanf(at, "%31[^= ]=%31s%n", key, value, &length) != 2) return TY_ERROR_INTERNAL;
        length += at[length] == ' ' ? 1 : 0;
        result = ty_options_set(ty_scene_context(scene), method->options, def, key, value);
    }
    return result;
}

/* Records what a method tells of its solve. */
static void note_solve(figure_run* run, const char* item, const ty_method* method, const ty_method_run* done) {
    const void* stats = done->stats;
    const ty_pop_stats* pop = stats;
    const ty_dom_stats* dom = stats;
    const ty_fld_stats* fld = stats;
    if (done->enclosed) {
        figure_note(run, item, "time of the solve", "s", done->interiors.seconds);
        figure_expect(run, item, "converged", "1", done->interiors.converged ? 1 : 0, 1, 0);
        return;
    }
    if (method == &ty_method_pop)
        figure_note(run, item, "time before the march", "s", pop->seconds - pop->march_seconds);
    if (method == &ty_method_dom) {
        int32_t sweeps = 0;
        for (int32_t plane = 0; plane < dom->planes; ++plane) sweeps += dom->sweeps[plane];
        figure_notes(run, item, {"time before the march", "s", dom->seconds - dom->march_seconds},
                     {"sweeps", "1", sweeps});
        figure_expect(run, item, "converged", "1", dom->converged ? 1 : 0, 1, 0);
    }
    if (method == &ty_method_fld || method == &ty_method_cda) {
        figure_note(run, item, "time of the solve", "s", fld->solve_seconds);
        figure_expect(run, item, "converged", "1", fld->converged ? 1 : 0, 1, 0);
    }
}

ty_result figure_render_variant(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variant,
                                const int32_t size[2], figure_picture* out, cli_report* report) {
    _Alignas(16) char before[FIGURE_DEF_SIZE], def[FIGURE_DEF_SIZE];
    cli_report own;
    const ty_method* method = variant->method;
    if (report == NULL) report = &own;
    if (variant->render != NULL) return variant->render(run, item, scene, size, variant->user, out);
    ty_result result = TY_OK;
    if (variant->options != NULL) {
        result = figure_method_def(scene, method, NULL, before);
        if (result == TY_OK) result = figure_method_def(scene, method, variant->options, def);
        if (result == TY_OK) result = ty_method_set_options(scene, method->options->name, def);
    }
    if (result == TY_OK) result = figure_render(run, item, scene, method, size, out, report);
    if (result == TY_OK) note_solve(run, item, method, &report->run);
    if (result == TY_OK && variant->options != NULL)
        result = ty_method_set_options(scene, method->options->name, before);
    return result;
}

/* ---- sheets ---- */

void figure_describe_errors(figure_run* run, bool without_noise) {
    const size_t used = strlen(run->caption);
    snprintf(run->caption + used, sizeof run->caption - used, " Errors are of means over %d × %d pixels%s.",
             FIGURE_BLOCK, FIGURE_BLOCK, without_noise ? ", the relative RMSE without the truth's own noise" : "");
}

/* One column. truth NULL: the column is the reference itself. */
static ty_result show_variant(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variant,
                              int column, const int32_t size[2], const figure_picture* truth, plot_sheet* sheet,
                              figure_picture* picture, figure_errors* errors) {
    char own[FIGURE_NAME_SIZE];
    snprintf(own, sizeof own, "%s, %s", item, variant->title);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "%s", variant->title);
    ty_result result = figure_render_variant(run, own, scene, variant, size, picture, NULL);
    if (result == TY_OK)
        result = figure_show(run, own, scene, picture, truth, false, plot_sheet_cell(sheet, 0, column), errors);
    if (result != TY_OK || truth == NULL) return result;
    return figure_error_map(run, picture->image, truth->image, figure_block(truth->image),
                            &plot_sheet_cell(sheet, 1, column)->picture);
}

ty_result figure_show_variants(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variants,
                               int count, const int32_t size[2], double picture_width, figure_errors* errors) {
    plot_sheet sheet;
    figure_picture truth = {0};
    ty_result result = plot_create_sheet(2, 1 + count, picture_width, &sheet);
    if (result != TY_OK) return result;
    snprintf(sheet.row_titles[1], PLOT_LABEL_SIZE, "errors");
    result = show_variant(run, item, scene, &figure_path, 0, size, NULL, &sheet, &truth, NULL);
    for (int i = 0; i < count && result == TY_OK; ++i) {
        figure_picture picture = {0};
        result = show_variant(run, item, scene, &variants[i], 1 + i, size, &truth, &sheet, &picture, &errors[i]);
        figure_free_picture(&picture);
    }
    figure_place_sheet(run, result, &sheet, &figure_error_scale);
    figure_free_picture(&truth);
    return result;
}

ty_result figure_show_scene(figure_run* run, const figure_scene* from, const figure_variant* variants, int count,
                            double picture_width, figure_errors* errors) {
    int32_t size[2];
    ty_scene* scene = NULL;
    figure_view_size(run, from->width, from->height, size);
    ty_result result = figure_load(run, from, &scene);
    if (result == TY_OK)
        result = figure_show_variants(run, from->item != NULL ? from->item : from->title, scene, variants, count, size,
                                      picture_width, errors);
    ty_scene_destroy(scene);
    return result;
}

static ty_result fill_column(figure_run* run, figure_matrix* matrix, int column, plot_sheet* sheet) {
    const figure_scene* from = &matrix->scenes[column];
    figure_picture* pictures = matrix->pictures[column];
    int32_t size[2];
    ty_scene* scene = NULL;
    figure_view_size(run, from->width, from->height, size);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "%s", from->title);
    ty_result result = figure_load(run, from, &scene);
    for (int row = 0; row < matrix->variant_count && result == TY_OK; ++row) {
        const figure_variant* variant = &matrix->variants[row];
        char item[FIGURE_NAME_SIZE];
        snprintf(item, sizeof item, "%s, %s", from->item != NULL ? from->item : from->title, variant->title);
        result = figure_render_variant(run, item, scene, variant, size, &pictures[row], NULL);
        if (result == TY_OK)
            result = figure_show(run, item, scene, &pictures[row], row > 0 ? &pictures[0] : NULL, variant->level,
                                 plot_sheet_cell(sheet, row, column), &matrix->errors[column][row]);
    }
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_show_matrix(figure_run* run, figure_matrix* matrix, double picture_width) {
    plot_sheet sheet;
    ty_result result = plot_create_sheet(matrix->variant_count, matrix->scene_count, picture_width, &sheet);
    if (result != TY_OK) return result;
    for (int row = 0; row < matrix->variant_count; ++row)
        snprintf(sheet.row_titles[row], PLOT_LABEL_SIZE, "%s", matrix->variants[row].title);
    for (int column = 0; column < matrix->scene_count && result == TY_OK; ++column)
        result = fill_column(run, matrix, column, &sheet);
    figure_place_sheet(run, result, &sheet, NULL);
    return result;
}

void figure_free_matrix(figure_matrix* matrix) {
    for (int column = 0; column < matrix->scene_count; ++column)
        for (int row = 0; row < matrix->variant_count; ++row) figure_free_picture(&matrix->pictures[column][row]);
}
