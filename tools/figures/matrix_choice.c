/* The choices of method auto on the scenes of the matrix, against the method of the smallest error in their time. */
#include "figures/matrix.h"

#include <math.h>
#include <string.h>

/* Methods count as equally fast up to this factor, and errors as equal below this one. */
static const double time_slack = 1.5, error_floor = 0.005;

ty_result matrix_choose(figure_run* run, const char* path, matrix_row* row) {
    const ty_choose_def def = ty_default_choose_def();
    ty_scene* scene = NULL;
    ty_choice choice;
    ty_result result = ty_scene_load(run->session->context, path, NULL, 0, &scene);
    if (result == TY_OK) result = ty_choose_method(scene, &def, &choice);
    if (result == TY_OK) row->choice = choice.method;
    ty_scene_destroy(scene);
    return result;
}

/* The error of path in `ratio` times the time of so many samples, by the noise of the reference. */
static double path_error(const matrix_row* row, double samples, double ratio) {
    return row->noise * sqrt(row->reference.samples / (samples * ratio));
}

static double error_in(const matrix_table* table, const matrix_row* row, int32_t method, double seconds) {
    const matrix_cell* cell = &row->cells[method];
    if (cell->state != MATRIX_RENDERED) return INFINITY;
    if (strcmp(table->methods[method], "path") == 0) {
        const double ratio = fmax(seconds, 1e-3) / fmax(cell->seconds, 1e-3);
        return fmax(path_error(row, table->samples, ratio), error_floor);
    }
    return cell->seconds <= seconds * time_slack ? fmax(cell->rmse, error_floor) : INFINITY;
}

bool matrix_judge_choice(const matrix_table* table, const matrix_row* row, matrix_verdict* out) {
    int32_t chosen = 0;
    while (chosen < table->method_count && strcmp(table->methods[chosen], row->choice) != 0) ++chosen;
    if (chosen == table->method_count || row->cells[chosen].state != MATRIX_RENDERED) return false;
    const double seconds = row->cells[chosen].seconds;
    *out = (matrix_verdict){.error = error_in(table, row, chosen, seconds), .seconds = seconds};
    out->best_error = out->error;
    out->best = row->choice;
    for (int32_t m = 0; m < table->method_count; ++m) {
        const double error = error_in(table, row, m, seconds);
        if (error >= out->best_error) continue;
        out->best_error = error;
        out->best = table->methods[m];
    }
    return true;
}
