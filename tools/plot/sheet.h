/* Sheets: pictures in rows and columns, with titles above and lines of numbers below. */
#ifndef TY_PLOT_SHEET_H
#define TY_PLOT_SHEET_H

#include "plot/chart.h"

enum { PLOT_LINES_MAX = 3 };

typedef struct plot_cell {
    plot_picture picture; /* owned by the sheet; without pixels the cell stays empty */
    char title[PLOT_LABEL_SIZE];
    char lines[PLOT_LINES_MAX][PLOT_LABEL_SIZE];
    plot_picture inset; /* owned by the sheet; shown in the lower right corner */
    int32_t cut[4];     /* framed source of the inset in the picture: x, y, width, height; width 0: none */
} plot_cell;

typedef struct plot_sheet {
    int rows, columns;
    double picture_width; /* width of all pictures on the canvas; heights keep the aspect ratio */
    double inset_share;   /* width as a fraction of the picture's */
    plot_cell* cells;     /* row by row */
    char (*row_titles)[PLOT_LABEL_SIZE];
    char (*column_titles)[PLOT_LABEL_SIZE];
} plot_sheet;

/* Creates a sheet with empty titles and pictures. Errors: TY_ERROR_MEMORY. */
ty_result plot_create_sheet(int rows, int columns, double picture_width, plot_sheet* out);
void plot_free_sheet(plot_sheet* sheet);
plot_cell* plot_sheet_cell(plot_sheet* sheet, int row, int column);

/* Adds an inset that enlarges a rectangle of a cell's picture. Errors: TY_ERROR_MEMORY. */
ty_result plot_enlarge(plot_cell* cell, const int32_t rectangle[4]);

plot_extent plot_draw_sheet(plot_canvas* canvas, double x, double y, const plot_sheet* sheet);

#endif
