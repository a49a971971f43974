/* Line charts and colour bars. */
#ifndef TY_PLOT_CHART_H
#define TY_PLOT_CHART_H

#include "plot/axis.h"
#include "plot/canvas.h"

enum { PLOT_POINTS_MAX = 32, PLOT_SERIES_MAX = 8, PLOT_LABEL_SIZE = 96 };

/* How much room something took, from its upper left corner. */
typedef struct plot_extent {
    double width, height;
} plot_extent;

typedef struct plot_series {
    char name[PLOT_LABEL_SIZE];
    int count;
    double x[PLOT_POINTS_MAX], y[PLOT_POINTS_MAX];
    double error[PLOT_POINTS_MAX]; /* half the length of a bar about y; 0: none */
    bool dashed;                   /* a limit or what others found, not a measurement: no dots */
} plot_series;

typedef struct plot_chart {
    const char *title, *x_label, *y_label; /* labels with units; title may be NULL */
    bool x_logarithmic, y_logarithmic;     /* values there must be above 0; others are left out */
    double width, height;                  /* of the field between the axes, pixels; 0: 420 x 260 */
    int series_count;
    plot_series series[PLOT_SERIES_MAX];
} plot_chart;

/* Adds a point to a series that has room. */
void plot_add_point(plot_series* series, double x, double y, double error);

plot_extent plot_draw_chart(plot_canvas* canvas, double x, double y, const plot_chart* chart);

/* A bar of a map's colours with numbers below and the label beside it. */
plot_extent plot_draw_color_bar(plot_canvas* canvas, double x, double y, double width, const plot_scale* scale);

#endif
