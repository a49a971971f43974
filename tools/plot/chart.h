/* Line charts and color bars. */
#ifndef TY_PLOT_CHART_H
#define TY_PLOT_CHART_H

#include "plot/axis.h"
#include "plot/canvas.h"

enum { PLOT_POINTS_MAX = 64, PLOT_SERIES_MAX = 24, PLOT_LABEL_SIZE = 96 };

/* The size of a drawn element, from its upper left corner. */
typedef struct plot_extent {
    double width, height;
} plot_extent;

typedef enum plot_style {
    PLOT_LINE_AND_DOTS = 0,
    PLOT_DOTS = 1,  /* data compared with a line of the same color */
    PLOT_LINE = 2,  /* a theory */
    PLOT_DASHES = 3 /* another theory, a limit, or results of others */
} plot_style;

typedef struct plot_series {
    char name[PLOT_LABEL_SIZE]; /* "": not in the legend */
    int count;
    double x[PLOT_POINTS_MAX], y[PLOT_POINTS_MAX];
    double error[PLOT_POINTS_MAX]; /* half length of an error bar about y; 0: none */
    plot_style style;
    int color; /* 1, 2, ...: color of the first, second series; 0: own color */
} plot_series;

typedef struct plot_chart {
    const char *title, *x_label, *y_label; /* labels with units; title may be NULL */
    bool x_logarithmic, y_logarithmic;     /* values must be positive; others are left out */
    double width, height;                  /* size of the plot area, pixels; 0: 420 x 260 */
    int series_count;
    plot_series series[PLOT_SERIES_MAX];
} plot_chart;

/* Adds a point to a series with free capacity. */
void plot_add_point(plot_series* series, double x, double y, double error);

plot_extent plot_draw_chart(plot_canvas* canvas, double x, double y, const plot_chart* chart);

/* A color bar with numbers below and the label beside it. */
plot_extent plot_draw_color_bar(plot_canvas* canvas, double x, double y, double width, const plot_scale* scale);

#endif
