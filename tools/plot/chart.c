/* Drawing charts. */
#include "plot/chart.h"

#include <math.h>

enum { TICK = 5, GAP = 8, BAR_HEIGHT = 14, BAR_COLORS = 256 };

static const plot_text number_text = {13, false, PLOT_CENTER, {0.13, 0.13, 0.15}};
static const plot_text label_text = {14, false, PLOT_CENTER, {0.13, 0.13, 0.15}};
static const plot_text legend_text = {14, false, PLOT_LEFT, {0.13, 0.13, 0.15}};
static const plot_text title_text = {15, true, PLOT_LEFT, {0.13, 0.13, 0.15}};
static const plot_color grid_color = {0.88, 0.88, 0.89};

void plot_add_point(plot_series* series, double x, double y, double error) {
    if (series->count == PLOT_POINTS_MAX) return;
    series->x[series->count] = x;
    series->y[series->count] = y;
    series->error[series->count++] = error;
}

/* The plot area between the axes, and its content. */
typedef struct field {
    double left, top, width, height;
    plot_axis x, y;
} field;

static double position_x(const field* f, double value) {
    return f->left + f->width * plot_axis_position(&f->x, value);
}

static double position_y(const field* f, double value) {
    return f->top + f->height * (1 - plot_axis_position(&f->y, value));
}

static bool can_show(const plot_chart* chart, double x, double y) {
    return isfinite(x) && isfinite(y) && (!chart->x_logarithmic || x > 0) && (!chart->y_logarithmic || y > 0);
}

static void choose_axes(const plot_chart* chart, field* f) {
    double min[2] = {INFINITY, INFINITY}, max[2] = {-INFINITY, -INFINITY};
    for (int s = 0; s < chart->series_count; ++s) {
        const plot_series* series = &chart->series[s];
        for (int i = 0; i < series->count; ++i) {
            if (!can_show(chart, series->x[i], series->y[i])) continue;
            min[0] = fmin(min[0], series->x[i]);
            max[0] = fmax(max[0], series->x[i]);
            const double below = series->y[i] - series->error[i];
            min[1] = fmin(min[1], chart->y_logarithmic && below <= 0 ? series->y[i] : below);
            max[1] = fmax(max[1], series->y[i] + series->error[i]);
        }
    }
    for (int axis = 0; axis < 2; ++axis)
        if (!(min[axis] <= max[axis])) min[axis] = max[axis] = 1;
    f->x = chart->x_logarithmic ? plot_log_axis(min[0], max[0]) : plot_linear_axis(min[0], max[0]);
    f->y = chart->y_logarithmic ? plot_log_axis(min[1], max[1]) : plot_linear_axis(min[1], max[1]);
}

static void draw_x_axis(plot_canvas* canvas, const field* f, const char* label) {
    double ticks[PLOT_TICKS_MAX];
    const double bottom = f->top + f->height;
    const int count = plot_axis_ticks(&f->x, 7, ticks);
    for (int i = 0; i < count; ++i) {
        char text[PLOT_NUMBER_SIZE];
        const double x = position_x(f, ticks[i]);
        plot_format_number(ticks[i], 3, text);
        plot_draw_line(canvas, x, f->top, x, bottom, 1, grid_color);
        plot_draw_line(canvas, x, bottom, x, bottom + TICK, 1, plot_ink);
        plot_draw_text(canvas, x, bottom + TICK + 14, &number_text, text);
    }
    plot_draw_text(canvas, f->left + 0.5 * f->width, bottom + TICK + 34, &label_text, label);
}

static void draw_y_axis(plot_canvas* canvas, const field* f) {
    double ticks[PLOT_TICKS_MAX];
    plot_text style = number_text;
    style.align = PLOT_RIGHT;
    const int count = plot_axis_ticks(&f->y, 6, ticks);
    for (int i = 0; i < count; ++i) {
        char text[PLOT_NUMBER_SIZE];
        const double y = position_y(f, ticks[i]);
        plot_format_number(ticks[i], 3, text);
        plot_draw_line(canvas, f->left, y, f->left + f->width, y, 1, grid_color);
        plot_draw_line(canvas, f->left - TICK, y, f->left, y, 1, plot_ink);
        plot_draw_text(canvas, f->left - TICK - 3, y + 4.5, &style, text);
    }
}

/* Width of the numbers and the label left of the plot area. */
static double margin_left(plot_canvas* canvas, const field* f) {
    double ticks[PLOT_TICKS_MAX], widest = 0;
    const int count = plot_axis_ticks(&f->y, 6, ticks);
    for (int i = 0; i < count; ++i) {
        char text[PLOT_NUMBER_SIZE];
        plot_format_number(ticks[i], 3, text);
        widest = fmax(widest, plot_text_width(canvas, &number_text, text));
    }
    return widest + TICK + 3 + 24;
}

static void draw_error_bar(plot_canvas* canvas, const plot_chart* chart, const field* f, const plot_series* series,
                           int i, plot_color color) {
    if (!(series->error[i] > 0)) return;
    const double below = series->y[i] - series->error[i];
    const double x = position_x(f, series->x[i]), top = position_y(f, series->y[i] + series->error[i]);
    const double bottom = chart->y_logarithmic && below <= 0 ? f->top + f->height : position_y(f, below);
    plot_draw_line(canvas, x, top, x, bottom, 1.2, color);
    plot_draw_line(canvas, x - 3, top, x + 3, top, 1.2, color);
    plot_draw_line(canvas, x - 3, bottom, x + 3, bottom, 1.2, color);
}

static plot_color color_of(const plot_chart* chart, int index) {
    const int shared = chart->series[index].color;
    return plot_series_color(shared > 0 ? shared - 1 : index);
}

static bool has_line(const plot_series* series) {
    return series->style != PLOT_DOTS;
}

static bool has_dots(const plot_series* series) {
    return series->style == PLOT_LINE_AND_DOTS || series->style == PLOT_DOTS;
}

static void draw_series(plot_canvas* canvas, const plot_chart* chart, const field* f, int index) {
    const plot_series* series = &chart->series[index];
    const plot_color color = color_of(chart, index);
    double points[2 * PLOT_POINTS_MAX];
    int count = 0;
    for (int i = 0; i < series->count; ++i) {
        if (!can_show(chart, series->x[i], series->y[i])) continue;
        points[2 * count] = position_x(f, series->x[i]);
        points[2 * count++ + 1] = position_y(f, series->y[i]);
        draw_error_bar(canvas, chart, f, series, i, color);
    }
    if (has_line(series)) plot_draw_polyline(canvas, points, count, 2, color, series->style == PLOT_DASHES);
    for (int i = 0; i < count && has_dots(series); ++i)
        plot_draw_disc(canvas, points[2 * i], points[2 * i + 1], 3.6, color);
}

/* Draws the legend right of the plot area; returns its width. */
static double draw_legend(plot_canvas* canvas, const plot_chart* chart, const field* f) {
    double widest = 0, y = f->top + 12;
    const double left = f->left + f->width + 2 * GAP;
    for (int s = 0; s < chart->series_count; ++s) {
        const plot_series* series = &chart->series[s];
        if (series->name[0] == '\0') continue;
        const plot_color color = color_of(chart, s);
        const double line[4] = {left, y, left + 26, y};
        if (has_line(series)) plot_draw_polyline(canvas, line, 2, 2, color, series->style == PLOT_DASHES);
        if (has_dots(series)) plot_draw_disc(canvas, left + 13, y, 3.6, color);
        plot_draw_text(canvas, left + 34, y + 5, &legend_text, series->name);
        widest = fmax(widest, plot_text_width(canvas, &legend_text, series->name));
        y += 22;
    }
    return 2 * GAP + 34 + widest;
}

plot_extent plot_draw_chart(plot_canvas* canvas, double x, double y, const plot_chart* chart) {
    field f = {.width = chart->width > 0 ? chart->width : 420, .height = chart->height > 0 ? chart->height : 260};
    choose_axes(chart, &f);
    f.left = x + margin_left(canvas, &f);
    f.top = y + (chart->title != NULL ? 30 : 8);
    if (chart->title != NULL) plot_draw_text(canvas, x, y + 15, &title_text, chart->title);
    draw_x_axis(canvas, &f, chart->x_label);
    draw_y_axis(canvas, &f);
    plot_draw_text_upwards(canvas, x + 14, f.top + 0.5 * f.height, &label_text, chart->y_label);
    plot_draw_line(canvas, f.left, f.top, f.left, f.top + f.height, 1.2, plot_ink);
    plot_draw_line(canvas, f.left, f.top + f.height, f.left + f.width, f.top + f.height, 1.2, plot_ink);
    for (int s = 0; s < chart->series_count; ++s) draw_series(canvas, chart, &f, s);
    const double legend = draw_legend(canvas, chart, &f);
    return (plot_extent){f.left + f.width + legend - x, f.top + f.height + TICK + 42 - y};
}

static void fill_bar(const plot_scale* scale, float values[BAR_COLORS]) {
    for (int i = 0; i < BAR_COLORS; ++i)
        values[i] = (float)(scale->lower + (scale->upper - scale->lower) * (i + 0.5) / BAR_COLORS);
}

plot_extent plot_draw_color_bar(plot_canvas* canvas, double x, double y, double width, const plot_scale* scale) {
    float values[BAR_COLORS];
    plot_picture picture = {0};
    fill_bar(scale, values);
    if (plot_picture_of_values(plot_canvas_context(canvas), values, BAR_COLORS, 1, scale, &picture) == TY_OK)
        plot_draw_picture(canvas, x, y, width, BAR_HEIGHT, &picture, false);
    plot_free_picture(&picture);
    plot_draw_frame(canvas, x, y, width, BAR_HEIGHT, plot_faint);
    double ticks[PLOT_TICKS_MAX];
    const plot_axis axis = {scale->lower, scale->upper, false};
    const int count = plot_axis_ticks(&axis, 5, ticks);
    for (int i = 0; i < count; ++i) {
        char text[PLOT_NUMBER_SIZE];
        const double place = x + width * plot_axis_position(&axis, ticks[i]);
        plot_format_number(ticks[i], 3, text);
        plot_draw_line(canvas, place, y + BAR_HEIGHT, place, y + BAR_HEIGHT + TICK, 1, plot_ink);
        plot_draw_text(canvas, place, y + BAR_HEIGHT + TICK + 13, &number_text, text);
    }
    plot_draw_text(canvas, x + width + 2 * GAP, y + BAR_HEIGHT - 2, &legend_text, scale->label);
    return (plot_extent){width + 2 * GAP + plot_text_width(canvas, &legend_text, scale->label), BAR_HEIGHT + TICK + 20};
}
