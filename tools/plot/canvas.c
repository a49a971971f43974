/* The canvas: the only user of the drawing library. All calls are recorded, and drawn on writing. */
#include "plot/canvas.h"

#include "base/constants.h"

#include <cairo.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tyndall/io.h>

struct plot_canvas {
    ty_context* context;
    cairo_surface_t* recording;
    cairo_t* cairo;
};

plot_canvas* plot_canvas_create(ty_context* context) {
    plot_canvas* canvas = malloc(sizeof *canvas);
    if (canvas == NULL) return NULL;
    canvas->context = context;
    canvas->recording = cairo_recording_surface_create(CAIRO_CONTENT_COLOR_ALPHA, NULL);
    canvas->cairo = cairo_create(canvas->recording);
    /* Unhinted glyph positions, so that widths are additive. */
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_set_font_options(canvas->cairo, options);
    cairo_font_options_destroy(options);
    cairo_set_line_join(canvas->cairo, CAIRO_LINE_JOIN_ROUND);
    return canvas;
}

ty_context* plot_canvas_context(const plot_canvas* canvas) {
    return canvas->context;
}

void plot_canvas_destroy(plot_canvas* canvas) {
    if (canvas == NULL) return;
    cairo_destroy(canvas->cairo);
    cairo_surface_destroy(canvas->recording);
    free(canvas);
}

static void set_color(plot_canvas* canvas, plot_color color) {
    cairo_set_source_rgb(canvas->cairo, color.r, color.g, color.b);
}

static void set_font(plot_canvas* canvas, const plot_text* style) {
    cairo_select_font_face(canvas->cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           style->bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(canvas->cairo, style->size);
}

double plot_text_width(plot_canvas* canvas, const plot_text* style, const char* text) {
    cairo_text_extents_t extents;
    set_font(canvas, style);
    cairo_text_extents(canvas->cairo, text, &extents);
    return extents.x_advance;
}

plot_text plot_fit_text(plot_canvas* canvas, const plot_text* style, const char* text, double max_width) {
    const double width = plot_text_width(canvas, style, text);
    plot_text fitted = *style;
    if (width > max_width) fitted.size *= max_width / width;
    return fitted;
}

void plot_draw_text(plot_canvas* canvas, double x, double y, const plot_text* style, const char* text) {
    const double before = 0.5 * style->align * plot_text_width(canvas, style, text);
    set_color(canvas, style->color);
    cairo_move_to(canvas->cairo, x - before, y);
    cairo_show_text(canvas->cairo, text);
}

void plot_draw_text_upwards(plot_canvas* canvas, double x, double y, const plot_text* style, const char* text) {
    cairo_save(canvas->cairo);
    cairo_translate(canvas->cairo, x, y);
    cairo_rotate(canvas->cairo, -0.5 * TY_PI_F64);
    plot_draw_text(canvas, 0, 0, style, text);
    cairo_restore(canvas->cairo);
}

void plot_draw_line(plot_canvas* canvas, double x0, double y0, double x1, double y1, double width, plot_color color) {
    const double points[4] = {x0, y0, x1, y1};
    plot_draw_polyline(canvas, points, 2, width, color, false);
}

void plot_draw_polyline(plot_canvas* canvas, const double* points, int count, double width, plot_color color,
                        bool dashed) {
    const double dashes[2] = {4 * width, 3 * width};
    cairo_new_path(canvas->cairo); /* text sets a current point, from which a line would start */
    for (int i = 0; i < count; ++i) cairo_line_to(canvas->cairo, points[2 * i], points[2 * i + 1]);
    set_color(canvas, color);
    cairo_set_line_width(canvas->cairo, width);
    cairo_set_dash(canvas->cairo, dashes, dashed ? 2 : 0, 0);
    cairo_stroke(canvas->cairo);
    cairo_set_dash(canvas->cairo, NULL, 0, 0);
}

void plot_draw_frame(plot_canvas* canvas, double x, double y, double width, double height, plot_color color) {
    set_color(canvas, color);
    cairo_set_line_width(canvas->cairo, 1);
    cairo_rectangle(canvas->cairo, x + 0.5, y + 0.5, width - 1, height - 1);
    cairo_stroke(canvas->cairo);
}

void plot_draw_disc(plot_canvas* canvas, double x, double y, double radius, plot_color color) {
    set_color(canvas, color);
    cairo_new_sub_path(canvas->cairo);
    cairo_arc(canvas->cairo, x, y, radius, 0, 2 * TY_PI_F64);
    cairo_fill(canvas->cairo);
}

/* A surface that owns a copy of the pixels; the caller destroys it. */
static cairo_surface_t* copy_pixels(const plot_picture* picture) {
    cairo_surface_t* surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, picture->width, picture->height);
    uint8_t* data = cairo_image_surface_get_data(surface);
    if (data == NULL) return surface;
    const size_t stride = (size_t)cairo_image_surface_get_stride(surface);
    for (int32_t y = 0; y < picture->height; ++y) {
        uint32_t* row = (uint32_t*)(void*)(data + (size_t)y * stride);
        const uint8_t* from = picture->rgb8 + 3 * (size_t)y * (size_t)picture->width;
        for (int32_t x = 0; x < picture->width; ++x, from += 3)
            row[x] = (uint32_t)from[0] << 16 | (uint32_t)from[1] << 8 | from[2];
    }
    cairo_surface_mark_dirty(surface);
    return surface;
}

void plot_draw_picture(plot_canvas* canvas, double x, double y, double width, double height,
                       const plot_picture* picture, bool sharp) {
    cairo_surface_t* surface = copy_pixels(picture);
    cairo_save(canvas->cairo);
    cairo_rectangle(canvas->cairo, x, y, width, height);
    cairo_clip(canvas->cairo);
    cairo_translate(canvas->cairo, x, y);
    cairo_scale(canvas->cairo, width / picture->width, height / picture->height);
    cairo_set_source_surface(canvas->cairo, surface, 0, 0);
    cairo_pattern_set_filter(cairo_get_source(canvas->cairo), sharp ? CAIRO_FILTER_NEAREST : CAIRO_FILTER_GOOD);
    cairo_pattern_set_extend(cairo_get_source(canvas->cairo), CAIRO_EXTEND_PAD);
    cairo_paint(canvas->cairo);
    cairo_restore(canvas->cairo);
    cairo_surface_destroy(surface);
}

/* An encoded picture; open_memstream would lose bytes silently where memory runs out. */
typedef struct encoded {
    uint8_t* bytes;
    size_t size, capacity;
} encoded;

static cairo_status_t append_bytes(void* user, const unsigned char* bytes, unsigned size) {
    encoded* to = user;
    if (size > to->capacity - to->size) {
        const size_t capacity = 2 * (to->capacity + size);
        uint8_t* moved = realloc(to->bytes, capacity);
        if (moved == NULL) return CAIRO_STATUS_NO_MEMORY;
        to->bytes = moved;
        to->capacity = capacity;
    }
    memcpy(to->bytes + to->size, bytes, size);
    to->size += size;
    return CAIRO_STATUS_SUCCESS;
}

static ty_result write_surface(ty_context* context, cairo_surface_t* surface, const char* path) {
    encoded png = {0};
    const cairo_status_t status = cairo_surface_write_to_png_stream(surface, append_bytes, &png);
    const bool whole = status == CAIRO_STATUS_SUCCESS && png.size > 0;
    const ty_result result = whole ? ty_bytes_write(context, path, png.bytes, png.size) : TY_ERROR_MEMORY;
    free(png.bytes);
    return result;
}

ty_result plot_canvas_write(plot_canvas* canvas, double width, double height, const char* path) {
    if (cairo_status(canvas->cairo) != CAIRO_STATUS_SUCCESS) return TY_ERROR_MEMORY;
    cairo_surface_t* surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)ceil(width), (int)ceil(height));
    cairo_t* cairo = cairo_create(surface);
    cairo_set_source_rgb(cairo, 1, 1, 1);
    cairo_paint(cairo);
    cairo_set_source_surface(cairo, canvas->recording, 0, 0);
    cairo_paint(cairo);
    const bool drawn = cairo_status(cairo) == CAIRO_STATUS_SUCCESS;
    cairo_destroy(cairo);
    const ty_result result = drawn ? write_surface(canvas->context, surface, path) : TY_ERROR_MEMORY;
    cairo_surface_destroy(surface);
    return result;
}
