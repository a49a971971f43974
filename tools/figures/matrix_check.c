/* A part of the matrix against its stored table: no method may have become worse by more than noise. */
#include "figures/matrix.h"

#include <math.h>

/* The first scenes of the covering set, which have each kind of each factor. Margins of the relative RMSE: of standard
 * deviations of the picture's own noise, should a change draw other random numbers (the reference stays as it is), and
 * a part of the stored error for what other instruction sets round otherwise. */
enum { CHECKED = 20 };
static const double deviations = 2, margin_min = 0.005, part = 0.05;

/* Noise of a picture's blocks by its own paths, relative to its mean: of all light in path, else of what no medium
 * scattered. */
static double noise_of(const matrix_row* row, const matrix_cell* cell, int32_t samples) {
    if (cell == &row->bakes[0] || cell == &row->bakes[1]) return row->bake_noise;
    const double fraction = cell == &row->cells[0] ? 1 : row->features.unscattered;
    return fraction * cell->deviation / (MATRIX_BLOCK * sqrt(samples));
}

/* The excess of an error over the stored one, which should be 0; 1 where nothing was rendered that once was. */
static void judge(figure_run* run, const matrix_table* table, int32_t row, int32_t use) {
    char name[MATRIX_USE_SIZE], item[FIGURE_NAME_SIZE];
    const matrix_cell* cell = matrix_use(table, row, use, name);
    const matrix_row* of = &table->rows[row];
    matrix_cell stored;
    if (!matrix_find_measured(of->name, name, &stored) || stored.state != MATRIX_RENDERED) return;
    const double noise = noise_of(of, cell, table->samples);
    snprintf(item, sizeof item, "%.40s, %s", of->name, name); /* names differ in their first letters */
    figure_expect(run, item, "relative RMSE above the stored", "1",
                  cell->state == MATRIX_RENDERED ? fmax(cell->rmse - stored.rmse, 0) : 1, 0,
                  deviations * noise + fmax(part * stored.rmse, margin_min));
}

ty_result figure_matrix_check(figure_run* run) {
    char folder[FIGURE_PATH_SIZE];
    matrix_table table = {0};
    ty_result result = matrix_open(run, folder, &table);
    if (table.row_count > CHECKED) table.row_count = CHECKED;
    if (result == TY_OK) result = matrix_fill(run, folder, &table);
    for (int32_t i = 0; i < table.row_count && result == TY_OK; ++i)
        for (int32_t u = 0; u < matrix_use_count(&table); ++u) judge(run, &table, i, u);
    figure_caption(run,
                   "All methods, bakes and the viewer on %d scenes of the matrix: relative RMSE above that of the "
                   "stored table, with %g standard deviations of the noise as the tolerance.",
                   table.row_count, deviations);
    matrix_close(&table);
    return result;
}
