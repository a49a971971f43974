/* Fig. 4 of the paper: the width of the spread over distance, Eq. 2 (Elek 2013), and its profile, compared with the
 * spread of one pixel by the exact function and by the filters. */
#include "base/constants.h"
#include "figures/screen_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DISTANCES = 12, SHAPES = 3, SIDE = 97, CENTER = SIDE / 2, VARIANTS = 3, CURVE_POINTS = 60, SHAPE_POINTS = 37 };

/* The paper's medium. */
static const double absorption = 0.1, scattering = 0.3, mean_cosine = 0.9; /* 1/m, 1/m, 1 */
static const double shape_distances[SHAPES] = {6, 10, 20};                 /* m */
static const double longest = 40;                                          /* m */

static const struct {
    const char* name;
    ty_screen_variant variant;
} variants[VARIANTS] = {
    {"reference", TY_SCREEN_REFERENCE}, {"scatter", TY_SCREEN_SCATTER}, {"gather", TY_SCREEN_GATHER}};

/* Standard deviation of the Gaussian, m. Eq. 2 (Elek 2013) */
static double width_at(double s) {
    return sqrt(0.5 / (2 * absorption / (3 * s) + 4 / (s * s * s * scattering * (1 - mean_cosine))));
}

/* ---- one bright pixel ---- */

typedef struct dot {
    float *color[3], *out[3], *attenuated[3];
    float* distance;
} dot;

static float* plane(void) {
    return calloc((size_t)SIDE * SIDE, sizeof(float));
}

static void close_dot(dot* d) {
    for (int c = 0; c < 3; ++c) {
        free(d->color[c]);
        free(d->out[c]);
        free(d->attenuated[c]);
    }
    free(d->distance);
}

/* A single bright pixel on black, all pixels at one distance. */
static bool open_dot(double distance, dot* d) {
    bool opened = (d->distance = plane()) != NULL;
    for (int c = 0; c < 3; ++c) {
        d->color[c] = plane();
        d->out[c] = plane();
        d->attenuated[c] = plane();
        opened = opened && d->color[c] != NULL && d->out[c] != NULL && d->attenuated[c] != NULL;
    }
    for (int i = 0; i < SIDE * SIDE && opened; ++i) d->distance[i] = (float)distance;
    for (int c = 0; c < 3 && opened; ++c) d->color[c][CENTER * SIDE + CENTER] = 1000;
    return opened;
}

static ty_screen_image image_of(const dot* d) {
    ty_screen_image image = ty_default_screen_image();
    image.width = SIDE;
    image.height = SIDE;
    image.distance = d->distance;
    for (int c = 0; c < 3; ++c) {
        image.color.data[c] = d->color[c];
        image.out.data[c] = d->out[c];
    }
    image.color.row = image.out.row = image.distance_row = SIDE;
    return image;
}

/* Pixels per metre at distance s, for a spread of 6 pixels. */
static double focal_for(double s) {
    return 6 * s / width_at(s);
}

static ty_screen_def make_def(int variant, double s) {
    ty_screen_def def = ty_default_screen_def();
    for (int c = 0; c < 3; ++c) {
        def.sigma_s[c] = (float)scattering;
        def.sigma_a[c] = (float)absorption;
        def.g[c] = (float)mean_cosine;
    }
    def.focal[0] = def.focal[1] = focal_for(s);
    def.variant = variants[variant].variant;
    def.spread = TY_SCREEN_SPREAD_GAUSSIAN;
    return def;
}

static ty_result spread_dot(figure_run* run, int variant, double s, dot* d) {
    const ty_screen_def def = make_def(variant, s);
    const ty_screen_image image = image_of(d);
    ty_result result = ty_screen_apply(run->session->context, &def, &image, NULL, 0, NULL);
    if (result == TY_OK) result = ty_screen_split(run->session->context, &def, &image, d->attenuated, NULL, NULL);
    for (int i = 0; i < SIDE * SIDE && result == TY_OK; ++i) d->out[0][i] -= d->attenuated[0][i];
    return result;
}

/* Standard deviation of the scattered light along x, m. */
static double measure_width(const dot* d, double s) {
    double sum = 0, squares = 0;
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) {
            const double light = (double)d->out[0][y * SIDE + x];
            sum += light;
            squares += light * (x - CENTER) * (x - CENTER);
        }
    return sqrt(squares / sum) * s / focal_for(s);
}

/* ---- charts ---- */

static ty_result add_width(figure_run* run, int variant, double s, plot_series* series) {
    char item[FIGURE_NAME_SIZE];
    dot d = {.distance = NULL};
    ty_result result = open_dot(s, &d) ? spread_dot(run, variant, s, &d) : TY_ERROR_MEMORY;
    if (result == TY_OK) {
        const double width = measure_width(&d, s);
        const bool exact = variants[variant].variant != TY_SCREEN_GATHER;
        plot_add_point(series, s, width, 0);
        snprintf(item, sizeof item, "%s, %.3g m", variants[variant].name, s);
        figure_expect(run, item, exact ? "standard deviation" : "standard deviation, gathered", "m", width, width_at(s),
                      exact ? 0.02 * width_at(s) : NAN);
    }
    close_dot(&d);
    return result;
}

static ty_result fill_widths(figure_run* run, plot_chart* chart) {
    *chart = (plot_chart){.title = "(a) W(s)",
                          .x_label = "distance s, m",
                          .y_label = "standard deviation, m",
                          .series_count = 1 + VARIANTS};
    snprintf(chart->series[0].name, PLOT_LABEL_SIZE, "Eq. 2");
    chart->series[0].style = PLOT_LINE;
    for (int i = 1; i <= CURVE_POINTS; ++i)
        plot_add_point(&chart->series[0], longest * i / CURVE_POINTS, width_at(longest * i / CURVE_POINTS), 0);
    ty_result result = TY_OK;
    for (int v = 0; v < VARIANTS; ++v) {
        plot_series* series = &chart->series[1 + v];
        snprintf(series->name, PLOT_LABEL_SIZE, "%s", variants[v].name);
        series->style = PLOT_DOTS;
        for (int i = 1; i <= DISTANCES && result == TY_OK; ++i)
            result = add_width(run, v, longest * i / DISTANCES, series);
    }
    return result;
}

/* A row of the reference's spread pixel, normalized to a density, 1/m. */
static ty_result fill_shape(figure_run* run, int shape, plot_series* law, plot_series* measured) {
    const double s = shape_distances[shape], width = width_at(s), pixel = s / focal_for(s);
    dot d = {.distance = NULL};
    double sum = 0;
    ty_result result = open_dot(s, &d) ? spread_dot(run, 0, s, &d) : TY_ERROR_MEMORY;
    snprintf(law->name, PLOT_LABEL_SIZE, "s = %g m, W = %.3f m", s, width);
    law->style = PLOT_LINE;
    measured->style = PLOT_DOTS;
    measured->color = 1 + 2 * shape;
    for (int i = -CENTER; i <= CENTER && result == TY_OK; ++i) sum += (double)d.out[0][CENTER * SIDE + CENTER + i];
    for (int i = 0; i < SHAPE_POINTS && result == TY_OK; ++i) {
        const int at = 2 * (i - SHAPE_POINTS / 2);
        const double x = at * pixel;
        plot_add_point(law, x, exp(-0.5 * x * x / (width * width)) / (width * sqrt(2 * TY_PI_F64)), 0);
        if (i % 2 == 0) plot_add_point(measured, x, (double)d.out[0][CENTER * SIDE + CENTER + at] / sum / pixel, 0);
    }
    close_dot(&d);
    return result;
}

static ty_result fill_shapes(figure_run* run, plot_chart* chart) {
    *chart = (plot_chart){.title = "(b) spread at three distances",
                          .x_label = "across, m",
                          .y_label = "density, 1/m",
                          .series_count = 2 * SHAPES};
    ty_result result = TY_OK;
    for (int shape = 0; shape < SHAPES && result == TY_OK; ++shape)
        result = fill_shape(run, shape, &chart->series[2 * shape], &chart->series[2 * shape + 1]);
    return result;
}

ty_result figure_screen_spread(figure_run* run) {
    static plot_chart charts[2];
    ty_result result = fill_widths(run, &charts[0]);
    if (result == TY_OK) result = fill_shapes(run, &charts[1]);
    if (result == TY_OK) plot_page_charts(&run->page, charts, 2);
    figure_caption(run,
                   "Absorption %g/m, scattering %g/m, g = %g. Lines: the paper's Eq. 2. Dots in (a): how far one "
                   "bright pixel is spread by the exact function and by both filters; in (b) by the exact function.",
                   absorption, scattering, mean_cosine);
    return result;
}
