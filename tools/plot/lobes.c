/* Drawing lobes. */
#include "plot/lobes.h"

#include "base/constants.h"

#include <math.h>
#include <stdlib.h>

enum { TITLE = 26, LEGEND = 22, GAP = 10 };

static const plot_text title_text = {15, true, PLOT_LEFT, {0.13, 0.13, 0.15}};
static const plot_text legend_text = {13, false, PLOT_LEFT, {0.13, 0.13, 0.15}};
static const plot_color lattice_color = {0.88, 0.88, 0.89};
static const double full_turn = 2 * TY_PI_F64;

static void draw_lattice(plot_canvas* canvas, double x, double y, const plot_lobes* lobes) {
    const double width = lobes->cell * lobes->columns, height = lobes->cell * lobes->rows;
    for (int row = 0; row <= lobes->rows; ++row)
        plot_draw_line(canvas, x, y + lobes->cell * row, x + width, y + lobes->cell * row, 1, lattice_color);
    for (int column = 0; column <= lobes->columns; ++column)
        plot_draw_line(canvas, x + lobes->cell * column, y, x + lobes->cell * column, y + height, 1, lattice_color);
}

/* points: capacity for the closed curve. */
static void draw_curve(plot_canvas* canvas, double x, double y, const plot_lobes* lobes, const float* radii,
                       plot_color color, double* points) {
    for (int i = 0; i <= lobes->directions; ++i) {
        const double angle = full_turn * i / lobes->directions;
        const double radius = 0.5 * lobes->cell * (double)radii[i % lobes->directions];
        points[2 * i] = x + radius * cos(angle);
        points[2 * i + 1] = y - radius * sin(angle);
    }
    plot_draw_polyline(canvas, points, lobes->directions + 1, 1.2, color, false);
}

static void draw_series(plot_canvas* canvas, double x, double y, const plot_lobes* lobes, int index, double* points) {
    for (int row = 0; row < lobes->rows; ++row)
        for (int column = 0; column < lobes->columns; ++column)
            draw_curve(canvas, x + lobes->cell * (column + 0.5), y + lobes->cell * (row + 0.5), lobes,
                       lobes->series[index].radii + (row * lobes->columns + column) * lobes->directions,
                       plot_series_color(index), points);
}

plot_extent plot_draw_lobes(plot_canvas* canvas, double x, double y, const plot_lobes* lobes) {
    const double top = y + TITLE, width = lobes->cell * lobes->columns, height = lobes->cell * lobes->rows;
    double* points = calloc(2 * ((size_t)lobes->directions + 1), sizeof *points);
    plot_draw_text(canvas, x, y + 15, &title_text, lobes->title);
    draw_lattice(canvas, x, top, lobes);
    double left = x;
    for (int s = 0; s < lobes->series_count && points != NULL; ++s) {
        const double line[4] = {left, top + height + 14, left + 20, top + height + 14};
        draw_series(canvas, x, top, lobes, s, points);
        plot_draw_polyline(canvas, line, 2, 2, plot_series_color(s), false);
        plot_draw_text(canvas, left + 26, top + height + 18, &legend_text, lobes->series[s].name);
        left += 26 + plot_text_width(canvas, &legend_text, lobes->series[s].name) + 2 * GAP;
    }
    free(points);
    return (plot_extent){fmax(width, left - x), TITLE + height + LEGEND};
}
