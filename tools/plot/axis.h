/* Axes: from numbers to places, and where the ticks are. */
#ifndef TY_PLOT_AXIS_H
#define TY_PLOT_AXIS_H

#include <stdbool.h>
#include <stddef.h>

enum { PLOT_TICKS_MAX = 16, PLOT_NUMBER_SIZE = 32 };

typedef struct plot_axis {
    double lower, upper; /* lower < upper; both above 0 when logarithmic */
    bool logarithmic;
} plot_axis;

/* A linear axis that holds least..most and ends at round numbers; from 0 when least is not far above it. */
plot_axis plot_linear_axis(double least, double most);
/* A logarithmic one, between powers of ten, or 2 or 5 times one, with some room; least > 0. */
plot_axis plot_log_axis(double least, double most);

/* 0 at the lower end, 1 at the upper. */
double plot_axis_place(const plot_axis* axis, double value);
/* Fills ticks with round numbers from the lower end to the upper, some wanted of them; returns how many. */
int plot_axis_ticks(const plot_axis* axis, int wanted, double ticks[PLOT_TICKS_MAX]);

/* As people write it, with at most so many significant digits: "0.25", "1200", "3×10⁻⁵". */
void plot_format_number(double value, int digits, char out[PLOT_NUMBER_SIZE]);

#endif
