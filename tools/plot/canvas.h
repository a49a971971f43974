/* A sheet of paper without edges: lines, text and pictures at places in pixels, x to the right, y down. How large it is
 * is said when it is written. */
#ifndef TY_PLOT_CANVAS_H
#define TY_PLOT_CANVAS_H

#include "plot/color.h"
#include "plot/picture.h"

typedef struct plot_canvas plot_canvas;

typedef enum plot_align { PLOT_LEFT = 0, PLOT_CENTER = 1, PLOT_RIGHT = 2 } plot_align;

typedef struct plot_text {
    double size; /* pixels from one line to the next are about 1.3 of it */
    bool bold;
    plot_align align; /* which point of the text x is */
    plot_color color;
} plot_text;

/* What a canvas could not draw for want of memory is told by plot_canvas_write. NULL: not even the canvas. */
plot_canvas* plot_canvas_create(ty_context* context);
ty_context* plot_canvas_context(const plot_canvas* canvas);
void plot_canvas_destroy(plot_canvas* canvas);

/* y is the line that letters stand on. Text is UTF-8. */
void plot_draw_text(plot_canvas* canvas, double x, double y, const plot_text* style, const char* text);
/* The same, upwards. */
void plot_draw_text_upwards(plot_canvas* canvas, double x, double y, const plot_text* style, const char* text);
/* A style small enough for the text to be no wider than `room`. */
plot_text plot_fit_text(plot_canvas* canvas, const plot_text* style, const char* text, double room);
double plot_text_width(plot_canvas* canvas, const plot_text* style, const char* text);

void plot_draw_line(plot_canvas* canvas, double x0, double y0, double x1, double y1, double width, plot_color color);
/* points: count pairs x, y; dashed lines have gaps. */
void plot_draw_polyline(plot_canvas* canvas, const double* points, int count, double width, plot_color color,
                        bool dashed);
void plot_draw_frame(plot_canvas* canvas, double x, double y, double width, double height, plot_color color);
void plot_draw_disc(plot_canvas* canvas, double x, double y, double radius, plot_color color);
/* width x height pixels of the canvas; sharp keeps the picture's own pixels apart when they are enlarged. */
void plot_draw_picture(plot_canvas* canvas, double x, double y, double width, double height,
                       const plot_picture* picture, bool sharp);

/* The part of a canvas from (0, 0) to (width, height) on white, as a PNG, whole or not at all.
 * Errors: TY_ERROR_MEMORY, TY_ERROR_FILE. */
ty_result plot_canvas_write(plot_canvas* canvas, double width, double height, const char* path);

#endif
