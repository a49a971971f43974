/* Single scattering with sharp shadows, against the path tracer's channel of single scattering. */
#include "figures/view.h"

#include <string.h>

enum { SCENES = 3, ROWS = 3, PATH_SAMPLES = 256, PATH_SAMPLES_QUICK = 8, PICTURE_WIDTH = 320 };
enum { TRUTH = 0, OURS = 1, ERRORS = 2 };

static const char* const row_titles[ROWS] = {"path tracing", "lpv", "errors"};
static const struct {
    lpv_scene scene;
    int32_t size[2];
} scenes[SCENES] = {{LPV_SPONZA, {320, 180}}, {LPV_ATRIUM, {320, 180}}, {LPV_CORNELL, {320, 180}}};

/* The channel "single" of an image. */
static ty_result copy_single(const ty_image* image, ty_context* context, ty_image** out) {
    static const char* const names[3] = {"single.R", "single.G", "single.B"};
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const ty_result result = ty_image_create_rgb(context, width, height, out);
    for (int c = 0; c < 3 && result == TY_OK; ++c)
        memcpy(ty_image_plane(*out, c), ty_image_plane_const(image, ty_image_find_channel(image, names[c])),
               sizeof(float) * (size_t)width * (size_t)height);
    return result;
}

/* seed: added to the session's. seconds may be NULL. */
static ty_result render_single(figure_run* run, const ty_scene* scene, const ty_method* method, const int32_t size[2],
                               uint64_t seed, ty_image** out, double* seconds) {
    cli_report report = {0};
    ty_image* image = NULL;
    const cli_request request = {
        .spp = figure_samples(run, run->options->quick ? PATH_SAMPLES_QUICK : PATH_SAMPLES),
        .seed = run->session->common.seed + seed,
        .width = size[0],
        .height = size[1],
        .aovs = TY_AOV_SINGLE,
    };
    ty_result result = cli_render_method(run->session, scene, method, &request, &image, &report);
    if (result == TY_OK) result = copy_single(image, run->session->context, out);
    if (seconds != NULL)
        *seconds = method == &ty_method_path ? report.run.own_seconds
                                             : ((const ty_lpv_stats*)report.run.stats)->single_seconds;
    ty_image_destroy(image);
    return result;
}

/* Half of the samples each, so that their difference gives the noise of their mean. */
static ty_result render_truth(figure_run* run, const ty_scene* scene, const int32_t size[2], ty_image** out,
                              double* noise) {
    ty_image* other = NULL;
    ty_difference difference;
    ty_result result = render_single(run, scene, &ty_method_path, size, 0, out, NULL);
    if (result == TY_OK) result = render_single(run, scene, &ty_method_path, size, 1, &other, NULL);
    if (result == TY_OK)
        result = ty_image_compare(run->session->context, *out, other, figure_block(other), &difference);
    if (result == TY_OK) {
        const size_t count = (size_t)size[0] * (size_t)size[1];
        for (int c = 0; c < 3; ++c) {
            float* plane = ty_image_plane(*out, c);
            for (size_t i = 0; i < count; ++i) plane[i] = 0.5f * (plane[i] + ty_image_plane(other, c)[i]);
        }
        *noise = 0.5 * difference.rmse[3];
    }
    ty_image_destroy(other);
    return result;
}

static ty_result compare(figure_run* run, const char* name, const ty_image* ours, const ty_image* truth, double noise,
                         double seconds, plot_cell* cell) {
    ty_difference difference;
    char text[16];
    ty_result result = ty_image_compare(run->session->context, ours, truth, figure_block(truth), &difference);
    if (result != TY_OK) return result;
    const double mean = difference.rmse[3] / difference.relative_rmse[3];
    const double error = bench_without_noise(difference.rmse[3], noise) / mean;
    figure_format_error(error, text);
    snprintf(cell->lines[0], PLOT_LABEL_SIZE, "%.3g s", seconds);
    snprintf(cell->lines[1], PLOT_LABEL_SIZE, "mean ratio %.3f, rel. RMSE %s", difference.mean_ratio[3], text);
    figure_expect(run, name, "mean ratio", "1", difference.mean_ratio[3], 1, 0.02);
    figure_notes(run, name, {"relative RMSE", "1", error}, {"noise of the truth over its mean", "1", noise / mean},
                 {"time of single scattering", "s", seconds});
    return TY_OK;
}

static ty_result show_scene(figure_run* run, const ty_scene* scene, int s, int column, plot_sheet* sheet) {
    int32_t size[2];
    double noise = 0, seconds = 0;
    ty_image* images[2] = {NULL, NULL};
    const char* name = lpv_scene_names[scenes[s].scene];
    const double exposure = ty_scene_camera(scene).exposure + 1;
    figure_view_size(run, scenes[s].size[0], scenes[s].size[1], size);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "%s", name);
    ty_result result = render_truth(run, scene, size, &images[TRUTH], &noise);
    if (result == TY_OK) result = render_single(run, scene, &ty_method_lpv, size, 0, &images[OURS], &seconds);
    if (result == TY_OK)
        result = compare(run, name, images[OURS], images[TRUTH], noise, seconds, plot_sheet_cell(sheet, OURS, column));
    for (int row = 0; row < ERRORS && result == TY_OK; ++row)
        result = plot_picture_of_image(run->session->context, images[row], exposure,
                                       &plot_sheet_cell(sheet, row, column)->picture);
    if (result == TY_OK)
        result = figure_error_map(run, images[OURS], images[TRUTH], figure_block(images[TRUTH]),
                                  &plot_sheet_cell(sheet, ERRORS, column)->picture);
    for (int i = 0; i < 2; ++i) ty_image_destroy(images[i]);
    return result;
}

ty_result figure_lpv_shafts(figure_run* run) {
    plot_sheet sheet;
    const int first = tools_has_data(run->options->data, SPONZA_FILE) ? 0 : 1;
    ty_result result = plot_create_sheet(ROWS, SCENES - first, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    for (int row = 0; row < ROWS; ++row) snprintf(sheet.row_titles[row], PLOT_LABEL_SIZE, "%s", row_titles[row]);
    for (int s = first; s < SCENES && result == TY_OK; ++s) {
        ty_scene* scene = NULL;
        result = figure_load_scene(run, lpv_scene_files[scenes[s].scene], NULL, 0, &scene);
        if (result == TY_OK) result = show_scene(run, scene, s, s - first, &sheet);
        ty_scene_destroy(scene);
    }
    figure_place_sheet(run, result, &sheet, &figure_error_scale);
    figure_caption(run,
                   "Light that fog scatters once towards the camera and nothing else touches: shadow maps against the "
                   "path tracer's channel of it, twice %d samples a pixel. Errors are of means over %d × %d pixels, "
                   "the relative RMSE without the truth's own noise, which is known from its two halves.",
                   figure_samples(run, run->options->quick ? PATH_SAMPLES_QUICK : PATH_SAMPLES), FIGURE_BLOCK,
                   FIGURE_BLOCK);
    return result;
}
