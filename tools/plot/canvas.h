/* An unbounded canvas: lines, text and images at positions in pixels, x to the right, y down. The size is set on
 * writing. */
#ifndef TY_PLOT_CANVAS_H
#define TY_PLOT_CANVAS_H

#include "plot/color.h"
#include "plot/picture.h"

typedef struct plot_canvas plot_canvas;

typedef enum plot_align { PLOT_LEFT = 0, PLOT_CENTER = 1, PLOT_RIGHT = 2 } plot_align;

typedef struct plot_text {
    double size; /* font size, pixels; line spacing is about 1.3 times the size */
    bool bold;
    plot_align align; /* the anchor of the text at x */
    plot_color color;
} plot_text;

/* Creates a canvas. NULL: no memory. Later memory errors are reported by plot_canvas_write. */
plot_canvas* plot_canvas_create(ty_context* context);
ty_context* plot_canvas_context(const plot_canvas* canvas);
void plot_canvas_destroy(plot_canvas* canvas);

/* Draws UTF-8 text; y is the baseline. */
void plot_draw_text(plot_canvas* canvas, double x, double y, const plot_text* style, const char* text);
/* Draws text upwards. */
void plot_draw_text_upwards(plot_canvas* canvas, double x, double y, const plot_text* style, const char* text);
/* A style small enough for the text to fit into max_width. */
plot_text plot_fit_text(plot_canvas* canvas, const plot_text* style, const char* text, double max_width);
double plot_text_width(plot_canvas* canvas, const plot_text* style, const char* text);

void plot_draw_line(plot_canvas* canvas, double x0, double y0, double x1, double y1, double width, plot_color color);
/* points: count pairs x, y; dashed lines have gaps. */
void plot_draw_polyline(plot_canvas* canvas, const double* points, int count, double width, plot_color color,
                        bool dashed);
void plot_draw_frame(plot_canvas* canvas, double x, double y, double width, double height, plot_color color);
void plot_draw_disc(plot_canvas* canvas, double x, double y, double radius, plot_color color);
/* Draws a picture in width x height pixels of the canvas; sharp enlarges by nearest neighbor. */
void plot_draw_picture(plot_canvas* canvas, double x, double y, double width, double height,
                       const plot_picture* picture, bool sharp);

/* Writes the canvas from (0, 0) to (width, height) on white as a PNG, atomically. Errors: TY_ERROR_MEMORY,
 * TY_ERROR_FILE. */
ty_result plot_canvas_write(plot_canvas* canvas, double width, double height, const char* path);

#endif
