/* Lobes: polar curves on a lattice, such as radiance by direction at the cells of a slice. */
#ifndef TY_PLOT_LOBES_H
#define TY_PLOT_LOBES_H

#include "plot/chart.h"

enum { PLOT_LOBES_MAX = 4 };

typedef struct plot_lobe_series {
    char name[PLOT_LABEL_SIZE];
    const float* radii; /* radii of each point's curve, row by row from the top, in directions counterclockwise from the
                           right; 1: half a cell */
} plot_lobe_series;

typedef struct plot_lobes {
    const char* title;
    int rows, columns, directions;
    double cell; /* cell size, pixels */
    int series_count;
    plot_lobe_series series[PLOT_LOBES_MAX];
} plot_lobes;

plot_extent plot_draw_lobes(plot_canvas* canvas, double x, double y, const plot_lobes* lobes);

#endif
