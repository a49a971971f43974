/* Drawing tables. */
#include "plot/table.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

enum { LINE = 23, GAP = 26 };

ty_result plot_create_table(int rows, int columns, int head_rows, plot_table* out) {
    *out = (plot_table){rows, columns, head_rows, calloc((size_t)rows * (size_t)columns, PLOT_LABEL_SIZE)};
    return out->cells == NULL ? TY_ERROR_MEMORY : TY_OK;
}

void plot_free_table(plot_table* table) {
    free(table->cells);
    *table = (plot_table){0};
}

void plot_set_cell(plot_table* table, int row, int column, const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(table->cells[row * table->columns + column], PLOT_LABEL_SIZE, format, arguments);
    va_end(arguments);
}

static plot_text cell_style(const plot_table* table, int row, int column) {
    return (plot_text){14, row < table->head_rows, column == 0 ? PLOT_LEFT : PLOT_RIGHT, plot_ink};
}

static double column_width(plot_canvas* canvas, const plot_table* table, int column) {
    double widest = 0;
    for (int row = 0; row < table->rows; ++row) {
        const plot_text style = cell_style(table, row, column);
        widest = fmax(widest, plot_text_width(canvas, &style, table->cells[row * table->columns + column]));
    }
    return widest;
}

plot_extent plot_draw_table(plot_canvas* canvas, double x, double y, const plot_table* table) {
    double left = x + 8;
    for (int column = 0; column < table->columns; ++column) {
        const double width = column_width(canvas, table, column);
        for (int row = 0; row < table->rows; ++row) {
            const plot_text style = cell_style(table, row, column);
            const double baseline = y + LINE * row + 18 + (row >= table->head_rows ? 6 : 0);
            plot_draw_text(canvas, column == 0 ? left : left + width, baseline, &style,
                           table->cells[row * table->columns + column]);
        }
        left += width + GAP;
    }
    const double right = left - GAP + 8, bottom = y + LINE * table->rows + 12;
    plot_draw_line(canvas, x, y, right, y, 1.6, plot_ink);
    plot_draw_line(canvas, x, y + LINE * table->head_rows + 4, right, y + LINE * table->head_rows + 4, 0.8, plot_ink);
    plot_draw_line(canvas, x, bottom, right, bottom, 1.6, plot_ink);
    return (plot_extent){right - x, bottom + 4 - y};
}
