/* Common code of figures: recording numbers, comparing images. */
#define _POSIX_C_SOURCE 200809L
#include "figures/figure.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const plot_scale figure_error_scale = {PLOT_DIVERGING, -50, 50,
                                       "error, % of the reference or of a tenth of its mean, whichever is more"};

void figure_caption(figure_run* run, const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(run->caption, sizeof run->caption, format, arguments);
    va_end(arguments);
}

void figure_note(figure_run* run, const char* item, const char* name, const char* unit, double measured) {
    figure_expect(run, item, name, unit, measured, NAN, NAN);
}

void figure_note_numbers(figure_run* run, const char* item, const figure_number* numbers, size_t count) {
    for (size_t i = 0; i < count; ++i) figure_note(run, item, numbers[i].name, numbers[i].unit, numbers[i].measured);
}

void figure_expect(figure_run* run, const char* item, const char* name, const char* unit, double measured,
                   double expected, double tolerance) {
    if (run->count == run->capacity) {
        const size_t capacity = run->capacity == 0 ? 64 : 2 * run->capacity;
        figure_quantity* grown = realloc(run->quantities, capacity * sizeof *grown);
        run->incomplete = run->incomplete || grown == NULL;
        if (grown == NULL) return;
        run->quantities = grown;
        run->capacity = capacity;
    }
    figure_quantity* quantity = &run->quantities[run->count++];
    *quantity = (figure_quantity){.unit = unit, .measured = measured, .expected = expected, .tolerance = tolerance};
    snprintf(quantity->item, sizeof quantity->item, "%s", item);
    snprintf(quantity->name, sizeof quantity->name, "%s", name);
}

bool figure_has_data(const figure_run* run, const char* name) {
    return tools_has_data(run->options->data, name);
}

bool figure_find_data(figure_run* run, const char* name, char path[FIGURE_PATH_SIZE]) {
    const char* folder = run->options->data;
    snprintf(path, FIGURE_PATH_SIZE, "%s/%s", folder == NULL ? "" : folder, name);
    if (figure_has_data(run, name)) return true;
    cli_progress_clear(&run->session->progress);
    if (folder == NULL)
        cli_fail(CLI_USAGE, "%s is skipped: it needs %s; give its folder with --data or TYNDALL_DATA", run->name, name);
    else
        cli_fail(CLI_USAGE, "%s is skipped: %s: %s", run->name, path, strerror(errno));
    run->skipped = true;
    return false;
}

ty_result figure_load_scene(figure_run* run, const char* name, const char* const* overrides, int32_t override_count,
                            ty_scene** out) {
    return tools_load_scene(run->session->context, name, run->options->data, overrides, override_count, out);
}

ty_result figure_check_interrupt(void) {
    return cli_interrupted() ? TY_CANCELLED : TY_OK;
}

int32_t figure_samples(const figure_run* run, int32_t choice) {
    return run->options->samples > 0 ? run->options->samples : choice;
}

ty_result figure_note_difference(figure_run* run, const char* item, const ty_image* a, const ty_image* b,
                                 ty_difference* out) {
    ty_result result = ty_image_compare(run->session->context, a, b, 1, out);
    if (result == TY_OK)
        figure_notes(run, item, {"RMSE", "W m^-2 sr^-1", out->rmse[3]}, {"relative RMSE", "1", out->relative_rmse[3]},
                     {"relMSE", "1", out->rel_mse[3]});
    if (result == TY_OK) figure_expect(run, item, "energy ratio", "1", out->mean_ratio[3], 1, 0.01);
    return result;
}

/* R + G + B of means over block x block pixels, row by row, without partial blocks. NULL: no memory. */
static float* block_brightness(const ty_image* image, int32_t block) {
    const int32_t width = ty_image_width(image), columns = width / block, rows = ty_image_height(image) / block;
    const float* planes[3];
    float* sums = calloc((size_t)columns * (size_t)rows, sizeof *sums);
    if (sums == NULL || !ty_image_rgb_planes(image, planes)) return sums;
    for (int32_t y = 0; y < rows * block; ++y)
        for (int32_t x = 0; x < columns * block; ++x) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            sums[(size_t)(y / block) * (size_t)columns + (size_t)(x / block)] +=
                (planes[0][i] + planes[1][i] + planes[2][i]) / (float)(block * block);
        }
    return sums;
}

/* Converts values to percent deviations from the expected ones, relative to max(expected, mean / 10). */
static void compare_values(float* values, const float* expected, size_t count) {
    double mean = 0;
    for (size_t i = 0; i < count; ++i) mean += (double)expected[i] / (double)count;
    const float floor_value = (float)fmax(0.1 * mean, 1e-30);
    for (size_t i = 0; i < count; ++i)
        values[i] = 100 * (values[i] - expected[i]) / (expected[i] > floor_value ? expected[i] : floor_value);
}

ty_result figure_error_map(figure_run* run, const ty_image* a, const ty_image* b, int32_t block, plot_picture* out) {
    const int32_t columns = ty_image_width(b) / block, rows = ty_image_height(b) / block;
    float *values = block_brightness(a, block), *expected = block_brightness(b, block);
    ty_result result = TY_ERROR_MEMORY;
    if (values != NULL && expected != NULL) {
        compare_values(values, expected, (size_t)columns * (size_t)rows);
        result = plot_picture_of_values(run->session->context, values, columns, rows, &figure_error_scale, out);
    }
    free(values);
    free(expected);
    return result;
}

void figure_place_sheet(figure_run* run, ty_result result, plot_sheet* sheet, const plot_scale* bar) {
    if (result == TY_OK) plot_page_sheet(&run->page, sheet);
    if (result == TY_OK && bar != NULL) plot_page_color_bar(&run->page, bar);
    plot_free_sheet(sheet);
}
