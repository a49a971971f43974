/* Tables of text, set with rules above and below. */
#ifndef TY_PLOT_TABLE_H
#define TY_PLOT_TABLE_H

#include "plot/chart.h"

typedef struct plot_table {
    int rows, columns, head_rows;   /* head_rows of the rows stand above the rule, in bold */
    char (*cells)[PLOT_LABEL_SIZE]; /* row by row; the first column is left-aligned, the others right-aligned */
} plot_table;

/* Errors: TY_ERROR_MEMORY. */
ty_result plot_create_table(int rows, int columns, int head_rows, plot_table* out);
void plot_free_table(plot_table* table);
void plot_set_cell(plot_table* table, int row, int column, const char* format, ...)
    __attribute__((format(printf, 4, 5)));

plot_extent plot_draw_table(plot_canvas* canvas, double x, double y, const plot_table* table);

#endif
