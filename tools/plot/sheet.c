/* Drawing sheets. */
#include "plot/sheet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { GAP_X = 10, GAP_Y = 12, LINE = 18, INSET_EDGE = 6 };

static const plot_text title_text = {14, true, PLOT_CENTER, {0.13, 0.13, 0.15}};
static const plot_text cell_text = {14, false, PLOT_CENTER, {0.13, 0.13, 0.15}};
static const plot_text line_text = {13, false, PLOT_CENTER, {0.35, 0.35, 0.38}};
static const plot_color cut_color = {1, 1, 1};

ty_result plot_create_sheet(int rows, int columns, double picture_width, plot_sheet* out) {
    plot_sheet sheet = {.rows = rows, .columns = columns, .picture_width = picture_width, .inset_share = 0.38};
    sheet.cells = calloc((size_t)rows * (size_t)columns, sizeof *sheet.cells);
    sheet.row_titles = calloc((size_t)rows, sizeof *sheet.row_titles);
    sheet.column_titles = calloc((size_t)columns, sizeof *sheet.column_titles);
    if (sheet.cells == NULL || sheet.row_titles == NULL || sheet.column_titles == NULL) {
        plot_free_sheet(&sheet);
        return TY_ERROR_MEMORY;
    }
    *out = sheet;
    return TY_OK;
}

void plot_free_sheet(plot_sheet* sheet) {
    for (int i = 0; sheet->cells != NULL && i < sheet->rows * sheet->columns; ++i) {
        plot_free_picture(&sheet->cells[i].picture);
        plot_free_picture(&sheet->cells[i].inset);
    }
    free(sheet->cells);
    free(sheet->row_titles);
    free(sheet->column_titles);
    *sheet = (plot_sheet){0};
}

plot_cell* plot_sheet_cell(plot_sheet* sheet, int row, int column) {
    return &sheet->cells[row * sheet->columns + column];
}

ty_result plot_enlarge(plot_cell* cell, const int32_t rectangle[4]) {
    memcpy(cell->cut, rectangle, sizeof cell->cut);
    return plot_picture_crop(&cell->picture, rectangle, &cell->inset);
}

static double picture_height(const plot_sheet* sheet, const plot_picture* picture) {
    return picture->rgb8 == NULL ? 0 : round(sheet->picture_width * picture->height / picture->width);
}

/* Heights of a row: text above, pictures, text below. */
typedef struct row_heights {
    double title, picture;
    int lines;
} row_heights;

static row_heights measure_row(plot_sheet* sheet, int row) {
    row_heights heights = {0};
    for (int column = 0; column < sheet->columns; ++column) {
        const plot_cell* cell = plot_sheet_cell(sheet, row, column);
        if (cell->title[0] != '\0') heights.title = LINE + 2;
        heights.picture = fmax(heights.picture, picture_height(sheet, &cell->picture));
        for (int i = 0; i < PLOT_LINES_MAX; ++i)
            if (cell->lines[i][0] != '\0' && heights.lines <= i) heights.lines = i + 1;
    }
    return heights;
}

/* Text above or below a picture, shrunk to its width so that it does not overlap neighbors. */
static void draw_words(plot_canvas* canvas, double x, double y, double width, const plot_text* style,
                       const char* words) {
    const plot_text fitted = plot_fit_text(canvas, style, words, width);
    plot_draw_text(canvas, x + 0.5 * width, y, &fitted, words);
}

static void draw_inset(plot_canvas* canvas, double x, double y, const plot_sheet* sheet, const plot_cell* cell) {
    const double scale = sheet->picture_width / cell->picture.width;
    const double width = round(sheet->inset_share * sheet->picture_width);
    const double height = round(width * cell->inset.height / cell->inset.width);
    const double left = x + sheet->picture_width - width - INSET_EDGE;
    const double top = y + picture_height(sheet, &cell->picture) - height - INSET_EDGE;
    plot_draw_picture(canvas, left, top, width, height, &cell->inset, cell->cut[2] > 0);
    plot_draw_frame(canvas, left - 1, top - 1, width + 2, height + 2, cut_color);
    if (cell->cut[2] > 0)
        plot_draw_frame(canvas, round(x + scale * cell->cut[0]), round(y + scale * cell->cut[1]),
                        round(scale * cell->cut[2]), round(scale * cell->cut[3]), cut_color);
}

static void draw_cell(plot_canvas* canvas, double x, double y, const plot_sheet* sheet, const plot_cell* cell,
                      const row_heights* heights) {
    const double width = sheet->picture_width, top = y + heights->title;
    const double height = picture_height(sheet, &cell->picture);
    draw_words(canvas, x, top - 6, width, &cell_text, cell->title);
    if (cell->picture.rgb8 == NULL) return;
    plot_draw_picture(canvas, x, top, width, height, &cell->picture, width >= cell->picture.width);
    if (cell->inset.rgb8 != NULL) draw_inset(canvas, x, top, sheet, cell);
    for (int i = 0; i < PLOT_LINES_MAX; ++i)
        draw_words(canvas, x, top + heights->picture + LINE * (i + 1) - 2, width, &line_text, cell->lines[i]);
}

static bool any_title(char (*titles)[PLOT_LABEL_SIZE], int count) {
    for (int i = 0; i < count; ++i)
        if (titles[i][0] != '\0') return true;
    return false;
}

plot_extent plot_draw_sheet(plot_canvas* canvas, double x, double y, const plot_sheet* sheet) {
    plot_sheet own = *sheet;
    const double left = x + (any_title(own.row_titles, own.rows) ? 26 : 0);
    double top = y;
    if (any_title(own.column_titles, own.columns)) {
        for (int column = 0; column < own.columns; ++column)
            draw_words(canvas, left + (own.picture_width + GAP_X) * column, top + 14, own.picture_width, &title_text,
                       own.column_titles[column]);
        top += LINE + 4;
    }
    for (int row = 0; row < own.rows; ++row) {
        const row_heights heights = measure_row(&own, row);
        const double center = top + heights.title + 0.5 * heights.picture;
        const double room = heights.title + heights.picture + LINE * heights.lines;
        const plot_text fitted = plot_fit_text(canvas, &title_text, own.row_titles[row], room);
        plot_draw_text_upwards(canvas, x + 16, center, &fitted, own.row_titles[row]);
        for (int column = 0; column < own.columns; ++column)
            draw_cell(canvas, left + (own.picture_width + GAP_X) * column, top, &own,
                      plot_sheet_cell(&own, row, column), &heights);
        top += heights.title + heights.picture + LINE * heights.lines + GAP_Y;
    }
    return (plot_extent){left + (own.picture_width + GAP_X) * own.columns - GAP_X - x, top - GAP_Y + 4 - y};
}
