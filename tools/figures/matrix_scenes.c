/* The scenes of the matrix as files, and a sheet of them by path. */
#include "figures/matrix.h"
#include "figures/windows.h"
#include "cli/text/text_file.h"

#include <math.h>
#include <stdlib.h>

/* Of --quick: so many scenes, every so many of them. */
enum { QUICK_SCENES = 2, QUICK_STRIDE = 4, COLUMNS = 8 };

double matrix_mean(const double means[MATRIX_BLOCKS]) {
    double sum = 0;
    for (int i = 0; i < MATRIX_BLOCKS; ++i) sum += means[i] / MATRIX_BLOCKS;
    return sum;
}

double matrix_exposure(const matrix_row* row) {
    return log2(0.25 / fmax(matrix_mean(row->reference.mean), 1e-9));
}

/* ---- files ---- */

static ty_result print_scene(ty_context* context, FILE* file, const void* user) {
    (void)context;
    matrix_print_scene(user, file);
    return TY_OK;
}

static ty_result write_map(figure_run* run, const char* folder) {
    char path[MATRIX_PATH_SIZE];
    ty_image* image = NULL;
    snprintf(path, sizeof path, "%s/map.exr", folder);
    ty_result result = figure_create_windows(run->session->context, &image);
    if (result == TY_OK) result = ty_image_write_exr(run->session->context, image, path);
    ty_image_destroy(image);
    return result;
}

void matrix_scene_path(const char* folder, const matrix_row* row, char out[MATRIX_PATH_SIZE]) {
    snprintf(out, MATRIX_PATH_SIZE, "%s/%s.json", folder, row->name);
}

ty_result matrix_open(figure_run* run, char folder[FIGURE_PATH_SIZE], matrix_table* table) {
    matrix_scene scenes[MATRIX_SCENES];
    char path[MATRIX_PATH_SIZE];
    snprintf(folder, FIGURE_PATH_SIZE, "%s/matrix", run->options->folder);
    if (cli_make_folder("figure", folder) != CLI_GO) return TY_ERROR_FILE;
    *table = (matrix_table){.rows = calloc(MATRIX_SCENES, sizeof *table->rows)};
    if (table->rows == NULL) return TY_ERROR_MEMORY;
    table->samples = run->options->quick ? MATRIX_SAMPLES_QUICK : MATRIX_SAMPLES;
    table->row_count = run->options->quick ? QUICK_SCENES : MATRIX_SCENES;
    matrix_cover(scenes);
    ty_result result = write_map(run, folder);
    if (result == TY_OK) result = matrix_write_floors(run, folder);
    for (int32_t i = 0; i < table->row_count && result == TY_OK; ++i) {
        matrix_row* row = &table->rows[i];
        row->scene = scenes[run->options->quick ? i * QUICK_STRIDE : i];
        matrix_name(&row->scene, row->name);
        matrix_scene_path(folder, row, path);
        result = cli_write_text_file(run->session->context, path, print_scene, &row->scene);
    }
    return result;
}

void matrix_close(matrix_table* table) {
    for (int32_t i = 0; i < table->row_count; ++i)
        for (int32_t m = 0; m < table->method_count; ++m) plot_free_picture(&table->rows[i].cells[m].picture);
    free(table->rows);
}

/* ---- the sheet ---- */

static ty_result show_scene(figure_run* run, const char* folder, matrix_row* row, plot_cell* out) {
    static const char* const arguments[] = {"--method", "path", NULL};
    const int32_t* values = row->scene.values;
    char path[MATRIX_PATH_SIZE];
    figure_process process;
    ty_image* image = NULL;
    matrix_scene_path(folder, row, path);
    ty_result result = matrix_find_reference(run, folder, row);
    if (result == TY_OK) result = matrix_render(folder, path, arguments, &process);
    matrix_image_path(folder, path);
    if (result == TY_OK) result = ty_image_read(run->session->context, path, &image);
    if (result == TY_OK)
        result = plot_picture_of_image(run->session->context, image, matrix_exposure(row), &out->picture);
    ty_image_destroy(image);
    for (int line = 0; line < MATRIX_FACTORS / 2; ++line) {
        const int f = 2 * line;
        snprintf(out->lines[line], PLOT_LABEL_SIZE, "%s %s", matrix_factors[f].values[values[f]],
                 matrix_factors[f + 1].values[values[f + 1]]);
    }
    return result;
}

ty_result figure_matrix_scenes(figure_run* run) {
    char folder[FIGURE_PATH_SIZE];
    matrix_table table = {0};
    plot_sheet sheet;
    ty_result result = matrix_open(run, folder, &table);
    const int rows = (table.row_count + COLUMNS - 1) / COLUMNS;
    if (result == TY_OK) result = plot_create_sheet(rows, COLUMNS, 2 * MATRIX_WIDTH, &sheet);
    const bool created = result == TY_OK;
    for (int32_t i = 0; i < table.row_count && result == TY_OK; ++i)
        result = show_scene(run, folder, &table.rows[i], plot_sheet_cell(&sheet, i / COLUMNS, i % COLUMNS));
    if (created) figure_place_sheet(run, result, &sheet, NULL);
    matrix_close(&table);
    figure_note(run, "matrix", "scenes", "1", table.row_count);
    figure_caption(run,
                   "Scenes that cover all pairs of kinds of light, surroundings, medium, thickness, g and albedo, by "
                   "path at %d samples per pixel, each at an exposure of its own.",
                   MATRIX_SAMPLES);
    return result;
}
