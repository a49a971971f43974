/* Every method on every scene of the matrix, against stored references. */
#include "figures/matrix.h"
#include "method/registry.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void compare(const matrix_row* row, const double means[MATRIX_BLOCKS], matrix_cell* out) {
    const double mean = matrix_mean(row->reference.mean);
    double squares = 0;
    for (int i = 0; i < MATRIX_BLOCKS; ++i) {
        const double error = (means[i] - row->reference.mean[i]) / mean;
        squares += error * error / MATRIX_BLOCKS;
    }
    out->ratio = matrix_mean(means) / mean;
    out->rmse = sqrt(fmax(squares - row->noise * row->noise, 0));
}

static ty_result take_image(figure_run* run, const char* folder, const matrix_row* row, matrix_cell* out) {
    char path[MATRIX_PATH_SIZE];
    ty_image* image = NULL;
    matrix_image_path(folder, path);
    ty_result result = ty_image_read(run->session->context, path, &image);
    if (result != TY_OK) return result;
    if (matrix_block_means(image, out->means, NULL)) {
        compare(row, out->means, out);
    } else {
        out->state = MATRIX_FAILED;
        snprintf(out->words, sizeof out->words, "pixels are not finite");
    }
    result = plot_picture_of_image(run->session->context, image, matrix_exposure(row), &out->picture);
    ty_image_destroy(image);
    return result;
}

/* Processor times of the parts of a rendering. Stages of the view are per pixel, all others of a method are its solve.
 */
static void take_parts(const char* folder, bool path, matrix_cell* out) {
    static const char* const views[] = {"view_seconds",   "surface_seconds", "march_seconds",
                                        "single_seconds", "compose_seconds", "filtering_seconds"};
    char name[MATRIX_PATH_SIZE];
    matrix_stats_path(folder, name);
    json_t* root = json_load_file(name, 0, NULL);
    const double spp = json_number_value(json_object_get(root, "spp"));
    const double traced = fmin(json_number_value(json_object_get(root, "render_cpu_seconds")), out->seconds);
    double seconds = 0, view = 0;
    const char* key;
    json_t* method;
    json_object_foreach(root, key, method) {
        for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i)
            view += json_number_value(json_object_get(method, views[i]));
    }
    seconds = json_number_value(json_object_get(root, "render_seconds"));
    out->surface = path ? out->seconds : traced;
    out->deviation = json_number_value(json_object_get(root, "error")) * sqrt(spp);
    out->view = path ? 0 : (out->seconds - traced) * fmin(view / fmax(seconds - traced, 1e-9), 1);
    json_decref(root);
}

static ty_result fill_cell(figure_run* run, const char* folder, const matrix_table* table, const matrix_row* row,
                           const char* method, double loading, matrix_cell* out) {
    char scene[MATRIX_PATH_SIZE];
    char samples[16], lpv_samples[32];
    const char* const arguments[] = {"--method", method, "--spp", samples, "-D", lpv_samples, NULL};
    figure_process process;
    matrix_scene_path(folder, row, scene);
    snprintf(samples, sizeof samples, "%d", table->samples);
    snprintf(lpv_samples, sizeof lpv_samples, "render.lpv.spp=%d", table->samples); /* it shades surfaces itself */
    *out = (matrix_cell){.state = MATRIX_RENDERED, .ratio = NAN, .rmse = NAN};
    const ty_result result = matrix_render(folder, scene, arguments, &process);
    out->seconds = fmax(process.seconds - loading, 0);
    if (result != TY_OK) return result;
    if (process.status == 0) {
        take_parts(folder, strcmp(method, "path") == 0, out);
        return take_image(run, folder, row, out);
    }
    matrix_take_failure(&process, out);
    return TY_OK;
}

/* The processor time of the program and the scene without a picture. */
static ty_result measure_loading(const char* folder, const matrix_row* row, double* seconds) {
    static const char* const arguments[] = {"--method", "path", "--spp", "1", "--size", "1x1", NULL};
    char scene[MATRIX_PATH_SIZE];
    figure_process process;
    matrix_scene_path(folder, row, scene);
    const ty_result result = matrix_render(folder, scene, arguments, &process);
    *seconds = process.seconds;
    return result;
}

static void note(figure_run* run, const matrix_row* row, const char* method, const matrix_cell* cell) {
    char item[FIGURE_NAME_SIZE];
    snprintf(item, sizeof item, "%s, %s", row->name, method);
    if (cell->state != MATRIX_RENDERED) return;
    figure_notes(run, item, {"mean ratio", "1", cell->ratio}, {"relative RMSE", "1", cell->rmse},
                 {"time", "s", cell->seconds});
}

static ty_result fill_row(figure_run* run, const char* folder, const matrix_table* table, matrix_row* row) {
    char path[MATRIX_PATH_SIZE];
    double loading = 0;
    matrix_scene_path(folder, row, path);
    ty_result result = matrix_find_reference(run, folder, row);
    if (result == TY_OK) result = matrix_choose(run, path, row);
    if (result == TY_OK) result = measure_loading(folder, row, &loading);
    for (int32_t m = 0; m < table->method_count && result == TY_OK; ++m) {
        result = fill_cell(run, folder, table, row, table->methods[m], loading, &row->cells[m]);
        if (result == TY_OK) note(run, row, table->methods[m], &row->cells[m]);
    }
    if (result == TY_OK) result = matrix_bake(run, folder, row);
    if (result == TY_OK) result = matrix_view(run, folder, table, row);
    return result;
}

/* ---- the page ---- */

/* Pictures of all methods, scene by scene; those that rendered nothing are left empty. */
static void show(figure_run* run, matrix_table* table) {
    plot_sheet sheet;
    if (plot_create_sheet(table->row_count, table->method_count, MATRIX_WIDTH * 2, &sheet) != TY_OK) return;
    for (int32_t m = 0; m < table->method_count; ++m)
        snprintf(sheet.column_titles[m], PLOT_LABEL_SIZE, "%s", table->methods[m]);
    for (int32_t i = 0; i < table->row_count; ++i) {
        snprintf(sheet.row_titles[i], PLOT_LABEL_SIZE, "%s", table->rows[i].name);
        for (int32_t m = 0; m < table->method_count; ++m) {
            matrix_cell* cell = &table->rows[i].cells[m];
            plot_cell* shown = plot_sheet_cell(&sheet, i, m);
            shown->picture = cell->picture;
            cell->picture = (plot_picture){0};
            if (cell->state == MATRIX_RENDERED)
                snprintf(shown->lines[0], PLOT_LABEL_SIZE, "%.2f, %.3f", cell->ratio, cell->rmse);
            else
                snprintf(shown->lines[0], PLOT_LABEL_SIZE, "%s", cell->state == MATRIX_REFUSED ? "refuses" : "fails");
        }
    }
    figure_place_sheet(run, TY_OK, &sheet, NULL);
}

ty_result matrix_fill(figure_run* run, const char* folder, matrix_table* table) {
    ty_result result = TY_OK;
    while (ty_methods[table->method_count] != NULL && table->method_count < MATRIX_METHODS_MAX) {
        table->methods[table->method_count] = ty_methods[table->method_count]->name;
        ++table->method_count;
    }
    for (int32_t i = 0; i < table->row_count && result == TY_OK; ++i) {
        cli_progress_step(&run->session->progress, table->rows[i].name, i, table->row_count,
                          cli_wall_seconds() - run->session->started);
        result = fill_row(run, folder, table, &table->rows[i]);
    }
    return result;
}

ty_result figure_matrix_methods(figure_run* run) {
    char folder[FIGURE_PATH_SIZE], path[MATRIX_PATH_SIZE];
    matrix_table table = {0};
    ty_result result = matrix_open(run, folder, &table);
    if (result == TY_OK) result = matrix_fill(run, folder, &table);
    snprintf(path, sizeof path, "%s/tables.md", folder);
    if (result == TY_OK) result = matrix_write_tables(run->session->context, &table, path);
    snprintf(path, sizeof path, "%s/measured.txt", folder);
    if (result == TY_OK) result = matrix_write_measured(run->session->context, &table, path);
    if (result == TY_OK) show(run, &table);
    matrix_close(&table);
    figure_caption(
        run,
        "Methods on %d scenes of a covering set, %d × %d pixels. Below each picture: mean ratio and relative "
        "RMSE of means over %d × %d pixels, against stored means by path. Path itself: the scene's samples.",
        table.row_count, MATRIX_WIDTH, MATRIX_HEIGHT, MATRIX_BLOCK, MATRIX_BLOCK);
    return result;
}
