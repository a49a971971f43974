/* Measurements of the matrix as a text table of one line for each scene and use, which is stored. */
#define _GNU_SOURCE
#include "figures/matrix.h"
#include "cli/text/text_file.h"

#include <math.h>
#include <string.h>

/* The stored table: tools/scenes/matrix_measured.txt. */
extern const char matrix_measured_text[];

enum { LINE_SIZE = 256 };

static const char* const states[] = {"rendered", "refused", "failed", "crashed", "too_long", "left_out"};
enum { STATES = sizeof states / sizeof states[0] };

/* ---- uses: methods, bakes, the view ---- */

int32_t matrix_use_count(const matrix_table* table) {
    return table->method_count + MATRIX_BAKES + 1;
}

matrix_cell* matrix_use(const matrix_table* table, int32_t row, int32_t use, char name[MATRIX_USE_SIZE]) {
    matrix_row* of = &table->rows[row];
    const int32_t bake = use - table->method_count;
    if (bake < 0) {
        snprintf(name, MATRIX_USE_SIZE, "%s", table->methods[use]);
        return &of->cells[use];
    }
    if (bake < MATRIX_BAKES) {
        snprintf(name, MATRIX_USE_SIZE, "bake_%s", matrix_bakes[bake]);
        return &of->bakes[bake];
    }
    snprintf(name, MATRIX_USE_SIZE, "view");
    return &of->view;
}

/* ---- writing ---- */

static ty_result print_measured(ty_context* context, FILE* file, const void* user) {
    const matrix_table* table = user;
    char name[MATRIX_USE_SIZE];
    (void)context;
    fputs(
        "# The matrix as measured (make matrix): scene, method or use, what became of it, mean ratio, relative RMSE, "
        "processor\n# time in s, the parts of it that the view and the paths of surfaces take, the standard deviation "
        "of a pixel by one\n# such path over their mean.\n",
        file);
    for (int32_t i = 0; i < table->row_count; ++i)
        for (int32_t u = 0; u < matrix_use_count(table); ++u) {
            const matrix_cell* cell = matrix_use(table, i, u, name);
            fprintf(file, "%s %s %s", table->rows[i].name, name, states[cell->state]);
            if (cell->state == MATRIX_RENDERED)
                fprintf(file, " %.4f %.4f %.3g %.3g %.3g %.3g", cell->ratio, cell->rmse, cell->seconds, cell->view,
                        cell->surface, cell->deviation);
            fputc('\n', file);
        }
    return TY_OK;
}

ty_result matrix_write_measured(ty_context* context, const matrix_table* table, const char* path) {
    return cli_write_text_file(context, path, print_measured, table);
}

/* ---- reading ---- */

static bool read_line(const char* line, const char* scene, const char* use, matrix_cell* out) {
    char name[MATRIX_NAME_SIZE], of[MATRIX_USE_SIZE], state[MATRIX_USE_SIZE];
    *out = (matrix_cell){.state = MATRIX_LEFT_OUT, .ratio = NAN, .rmse = NAN};
    if (sscanf(line, "%55s %15s %15s %lf %lf %lf %lf %lf %lf", name, of, state, &out->ratio, &out->rmse, &out->seconds,
               &out->view, &out->surface, &out->deviation) < 3)
        return false;
    if (strcmp(name, scene) != 0 || strcmp(of, use) != 0) return false;
    for (int i = 0; i < STATES; ++i)
        if (strcmp(state, states[i]) == 0) out->state = (matrix_state)i;
    return true;
}

bool matrix_find_measured(const char* scene, const char* use, matrix_cell* out) {
    for (const char* line = matrix_measured_text; *line != '\0';) {
        char copy[LINE_SIZE];
        const size_t length = strcspn(line, "\n");
        snprintf(copy, sizeof copy, "%.*s", (int)(length < LINE_SIZE ? length : LINE_SIZE - 1), line);
        if (read_line(copy, scene, use, out)) return true;
        line += length + (line[length] != '\0');
    }
    return false;
}
