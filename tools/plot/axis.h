/* Axes: mapping of numbers to positions, and ticks. */
#ifndef TY_PLOT_AXIS_H
#define TY_PLOT_AXIS_H

#include <stdbool.h>
#include <stddef.h>

enum { PLOT_TICKS_MAX = 16, PLOT_NUMBER_SIZE = 32 };

typedef struct plot_axis {
    double lower, upper; /* lower < upper; both positive if logarithmic */
    bool logarithmic;
} plot_axis;

/* A linear axis over min..max with round ends; from 0 if min is near 0. */
plot_axis plot_linear_axis(double min, double max);
/* A logarithmic axis over min..max between 1, 2 or 5 times powers of ten, with a margin; min > 0. */
plot_axis plot_log_axis(double min, double max);

/* Position on the axis: 0 at the lower end, 1 at the upper. */
double plot_axis_position(const plot_axis* axis, double value);
/* Fills ticks with about `target_count` round numbers from the lower end to the upper; returns their number. */
int plot_axis_ticks(const plot_axis* axis, int target_count, double ticks[PLOT_TICKS_MAX]);

/* Formats a number with a maximum of significant digits: "0.25", "1200", "3×10⁻⁵". */
void plot_format_number(double value, int digits, char out[PLOT_NUMBER_SIZE]);

#endif
