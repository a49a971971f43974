/* Pages of figures: elements from top to bottom between a title and a caption. */
#ifndef TY_PLOT_PAGE_H
#define TY_PLOT_PAGE_H

#include "plot/chart.h"
#include "plot/lobes.h"
#include "plot/sheet.h"
#include "plot/table.h"

typedef struct plot_page {
    plot_canvas* canvas;
    double y, width; /* used height */
} plot_page;

/* Errors: TY_ERROR_MEMORY. */
ty_result plot_create_page(ty_context* context, plot_page* out);
void plot_free_page(plot_page* page);

void plot_page_sheet(plot_page* page, const plot_sheet* sheet);
/* Adds elements side by side. */
void plot_page_charts(plot_page* page, const plot_chart* charts, int count);
void plot_page_lobes(plot_page* page, const plot_lobes* lobes, int count);
void plot_page_table(plot_page* page, const plot_table* table);
void plot_page_color_bar(plot_page* page, const plot_scale* scale);

/* Adds title and caption and writes a PNG atomically. Errors: TY_ERROR_MEMORY, TY_ERROR_FILE. */
ty_result plot_write_page(plot_page* page, const char* title, const char* caption, const char* path);

#endif
