/* Colours: those of lines and text, and maps from numbers to colours. */
#ifndef TY_PLOT_COLOR_H
#define TY_PLOT_COLOR_H

/* sRGB, 0..1. */
typedef struct plot_color {
    double r, g, b;
} plot_color;

extern const plot_color plot_ink;   /* text and axes */
extern const plot_color plot_faint; /* grids, frames and remarks */

/* The color of one of several lines, from a palette for color-blind readers, too. */
plot_color plot_series_color(int index);

typedef enum plot_map {
    PLOT_SEQUENTIAL = 0, /* dark to light, perceptually uniform */
    PLOT_DIVERGING = 1   /* blue below the center, red above, white at the center */
} plot_map;

/* The color at t in 0..1, clamped, in linear Rec.709. NaN is green. */
void plot_map_color(plot_map map, double t, float rgb[3]);

#endif
