/* Ray effects of few ordinates: light from small bright regions through thin media, and narrow beams. */
#include "figures/fluence.h"

#include <math.h>
#include <stdlib.h>

enum { SCENES = 3, COUNTS = 4, WIDTH = 192, PICTURE_WIDTH = 280, SLICE = 32, SLICE_QUICK = 12, SAMPLES = 2048 };

/* Ordinates of the sweeps, and of one additional final sweep; 0: none. */
static const struct { int32_t all, last; } counts[COUNTS] = {{24, 0}, {96, 0}, {96, 400}, {400, 0}};

static void name_count(int index, char out[FIGURE_NAME_SIZE]) {
    if (counts[index].last == 0)
        snprintf(out, FIGURE_NAME_SIZE, "%d directions", (int)counts[index].all);
    else
        snprintf(out, FIGURE_NAME_SIZE, "%d directions, at last %d", (int)counts[index].all, (int)counts[index].last);
}

/* Grids fine enough for angular discretization to dominate the error. */
enum { RESOLUTION = 48 };

/* Scenes of 4 m, viewed from the front; thin media have sigma_s = 0.05/m. */
static const figure_scene scenes[SCENES] = {
    {.title = "lamp beside a blob", .scene = "dom_lamp_and_blob", .width = WIDTH, .height = WIDTH},
    {.title = "narrow beam", .scene = "dom_narrow_beam", .width = WIDTH, .height = WIDTH},
    {.title = "spot through smoke", .scene = "dom_spot_in_smoke", .width = WIDTH, .height = WIDTH},
};

/* ---- fluence in a slice ---- */

/* The box of the slice, in which scattered fluence is averaged; its thickness is 1/12 of its width. */
static fluence_box slice_box(const figure_run* run) {
    const int32_t side = run->options->quick ? SLICE_QUICK : SLICE;
    return (fluence_box){{-2, -2, -1.0 / 6}, {2, 2, 1.0 / 6}, {side, side, 1}};
}

/* Makes an image of a slice, top row first. */
static ty_result make_image(figure_run* run, const fluence_box* box, const double (*fluence)[3], ty_image** out) {
    const int32_t side = box->size[0];
    const ty_result result = ty_image_create_rgb(run->session->context, side, side, out);
    if (result != TY_OK) return result;
    for (int32_t y = 0; y < side; ++y)
        for (int32_t x = 0; x < side; ++x)
            for (int c = 0; c < 3; ++c)
                ty_image_plane(*out, c)[(side - 1 - y) * side + x] = (float)fluence[y * side + x][c];
    return TY_OK;
}

/* Shows a slice on a logarithmic scale. */
static ty_result show_slice(figure_run* run, const ty_image* image, const plot_scale* scale, plot_picture* out) {
    const int32_t side = ty_image_width(image);
    float* values = calloc((size_t)side * (size_t)side, sizeof *values);
    if (values == NULL) return TY_ERROR_MEMORY;
    const float* green = ty_image_plane_const(image, 1);
    for (int32_t i = 0; i < side * side; ++i) values[i] = log10f(fmaxf(green[i], 1e-20f));
    const ty_result result = plot_picture_of_values(run->session->context, values, side, side, scale, out);
    free(values);
    return result;
}

/* A scale of decades below the power of ten above the maximum. */
static plot_scale slice_scale(const ty_image* image) {
    const int32_t side = ty_image_width(image);
    float max_value = 1e-20f;
    for (int32_t i = 0; i < side * side; ++i) max_value = fmaxf(max_value, ty_image_plane_const(image, 1)[i]);
    const double top = ceil(log10((double)max_value));
    return (plot_scale){PLOT_SEQUENTIAL, top - 4, top, "scattered fluence in the slice, W/m², powers of ten"};
}

/* The reference and the results of discrete ordinates. */
typedef struct slice {
    fluence_box box;
    fluence_truth* truth;
    double (*fluence)[3];
    ty_image *expected, *found;
    plot_scale scale;
} slice;

/* The mean relative error per cell, including the reference's noise: it measures ray effects in dark cells. */
static double mean_error(const slice* s) {
    double sum = 0;
    const size_t cells = fluence_cells(&s->box);
    for (size_t i = 0; i < cells; ++i)
        sum += fabs(s->fluence[i][1] - s->truth->scattered[i][1]) / fmax(s->truth->scattered[i][1], 1e-20);
    return sum / (double)cells;
}

static ty_result fill_cell(figure_run* run, const char* item, const ty_scene* scene, int column, slice* s,
                           plot_sheet* sheet) {
    char count[FIGURE_NAME_SIZE], own[2 * FIGURE_NAME_SIZE], error[16];
    ty_dom_stats stats = ty_default_dom_stats();
    plot_cell* cell = plot_sheet_cell(sheet, 0, 1 + column);
    name_count(column, count);
    snprintf(own, sizeof own, "%s, slice, %s", item, count);
    ty_result result = dom_fluence(run, scene, counts[column].all, counts[column].last,
                                   run->options->quick ? TY_AUTO : RESOLUTION, &s->box, NULL, s->fluence, &stats);
    if (result == TY_OK) result = make_image(run, &s->box, (const double(*)[3])s->fluence, &s->found);
    if (result == TY_OK) result = show_slice(run, s->found, &s->scale, &cell->picture);
    if (result == TY_OK)
        result = figure_error_map(run, s->found, s->expected, 1, &plot_sheet_cell(sheet, 1, 1 + column)->picture);
    ty_image_destroy(s->found);
    s->found = NULL;
    if (result != TY_OK) return result;
    const figure_errors errors = fluence_compare(&s->box, (const double(*)[3])s->fluence, s->truth);
    figure_format_error(errors.relative_rmse, error);
    snprintf(cell->lines[0], PLOT_LABEL_SIZE, "mean ratio %.3f, rel. RMSE %s", errors.mean_ratio, error);
    const double off = mean_error(s);
    snprintf(cell->lines[1], PLOT_LABEL_SIZE, "cells are off by %.1f %% on average", 100 * off);
    figure_notes(run, own, {"mean ratio", "1", errors.mean_ratio},
                 {"mean of cells' relative errors, with noise", "1", off},
                 {"relative RMSE", "1", errors.relative_rmse});
    return TY_OK;
}

static ty_result fill_sheet(figure_run* run, const char* item, const ty_scene* scene, slice* s, plot_sheet* sheet) {
    ty_result result = path_fluence(run, scene, &s->box, SAMPLES, s->truth);
    if (result == TY_OK) result = make_image(run, &s->box, (const double(*)[3])s->truth->scattered, &s->expected);
    if (result == TY_OK) s->scale = slice_scale(s->expected);
    if (result == TY_OK) result = show_slice(run, s->expected, &s->scale, &plot_sheet_cell(sheet, 0, 0)->picture);
    snprintf(sheet->row_titles[0], PLOT_LABEL_SIZE, "fluence");
    snprintf(sheet->row_titles[1], PLOT_LABEL_SIZE, "errors");
    for (int column = 0; column < COUNTS && result == TY_OK; ++column)
        result = fill_cell(run, item, scene, column, s, sheet);
    return result;
}

static ty_result show_slices(figure_run* run, const char* item, const ty_scene* scene) {
    plot_sheet sheet = {0};
    slice s = {.box = slice_box(run),
               .truth = calloc(1, sizeof *s.truth),
               .fluence = calloc(FLUENCE_CELLS_MAX, sizeof *s.fluence)};
    ty_result result = s.truth != NULL && s.fluence != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) result = plot_create_sheet(2, 1 + COUNTS, PICTURE_WIDTH, &sheet);
    if (result == TY_OK) result = fill_sheet(run, item, scene, &s, &sheet);
    figure_place_sheet(run, result, &sheet, &s.scale);
    ty_image_destroy(s.expected);
    free(s.fluence);
    free(s.truth);
    return result;
}

/* ---- pictures ---- */

static ty_result show_scene(figure_run* run, const figure_scene* from) {
    char titles[COUNTS][FIGURE_NAME_SIZE], options[COUNTS][128];
    figure_variant variants[COUNTS];
    figure_errors errors[COUNTS];
    ty_scene* scene = NULL;
    for (int i = 0; i < COUNTS; ++i) {
        name_count(i, titles[i]);
        snprintf(options[i], sizeof options[i],
                 run->options->quick ? "directions=%d last_directions=%d resolution=auto direct=auto"
                                     : "directions=%d last_directions=%d resolution=48 direct=144",
                 (int)counts[i].all, (int)counts[i].last);
        variants[i] = (figure_variant){.title = titles[i], .method = &ty_method_dom, .options = options[i]};
    }
    ty_result result = figure_show_scene(run, from, variants, COUNTS, PICTURE_WIDTH, errors);
    if (result == TY_OK) result = figure_load(run, from, &scene);
    if (result == TY_OK) result = show_slices(run, from->title, scene);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_dom_rays(figure_run* run) {
    ty_result result = TY_OK;
    for (int i = 0; i < SCENES && result == TY_OK; ++i) result = show_scene(run, &scenes[i]);
    figure_caption(run,
                   "Boxes of 4 m, all isotropic: a lamp in thin air (σs = 0.05/m) beside a blob of 20/m; a beam 6° "
                   "wide in fog of 0.7/m; a spot light through smoke of noise. By path tracing and by 24, 96, 96 with "
                   "a last sweep of 400, and 400 directions through %d³ cells: pictures, and the fluence of light that "
                   "has scattered in a slice through the center. Errors of pictures are of means over %d × %d pixels, "
                   "relative RMSEs without the truth's own noise.",
                   RESOLUTION, FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}
