/* Sheets: pictures in rows and columns, with titles above and lines of figures below. */
#ifndef TY_PLOT_SHEET_H
#define TY_PLOT_SHEET_H

#include "plot/chart.h"

enum { PLOT_LINES_MAX = 3 };

typedef struct plot_cell {
    plot_picture picture; /* owned by the sheet; none: the cell stays empty */
    char title[PLOT_LABEL_SIZE];
    char lines[PLOT_LINES_MAX][PLOT_LABEL_SIZE];
    plot_picture inset; /* owned by the sheet; shown in the lower right corner */
    int32_t cut[4];     /* x, y, width, height in the picture: what the inset enlarges, framed; width 0: nothing */
} plot_cell;

typedef struct plot_sheet {
    int rows, columns;
    double picture_width; /* of all pictures on the canvas; their height follows */
    double inset_share;   /* of the picture's width */
    plot_cell* cells;     /* row by row */
    char (*row_titles)[PLOT_LABEL_SIZE];
    char (*column_titles)[PLOT_LABEL_SIZE];
} plot_sheet;

/* Titles and pictures are empty. Errors: TY_ERROR_MEMORY. */
ty_result plot_create_sheet(int rows, int columns, double picture_width, plot_sheet* out);
void plot_free_sheet(plot_sheet* sheet);
plot_cell* plot_sheet_cell(plot_sheet* sheet, int row, int column);

/* Gives a cell an inset that enlarges a rectangle of its picture. Errors: TY_ERROR_MEMORY. */
ty_result plot_enlarge(plot_cell* cell, const int32_t rectangle[4]);

plot_extent plot_draw_sheet(plot_canvas* canvas, double x, double y, const plot_sheet* sheet);

#endif
