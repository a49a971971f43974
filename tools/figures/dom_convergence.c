/* The number of sweeps of discrete ordinates with and without diffusion synthetic acceleration, in media from thin to
 * opaque. */
#include "figures/figure.h"
#include "bench/ordinates_box.h"

#include <math.h>
#include <stdlib.h>

enum {
    EDGE = 24,
    EDGE_QUICK = 8,
    DIRECTIONS = 96,
    DIRECTIONS_QUICK = 24,
    THICKNESSES = 9, /* 1 to 10,000 */
    SWEEPS = 400,
    SWEEPS_QUICK = 50,
    HISTORIES = 4,
    HISTORY_DOTS = 56,
    CHARTS = 2
};

static const double history_thickness[HISTORIES] = {1, 10, 100, 10000};

typedef struct solve_setting {
    ordinates_box_kind kind;
    double thickness;
    bool accelerated;
} solve_setting;

static ty_result solve(figure_run* run, const solve_setting* setting, double* history, ty_ordinates_stats* stats) {
    const bool quick = run->options->quick;
    ordinates_box box;
    ty_result result = ordinates_box_open(run->session->context, setting->kind, quick ? EDGE_QUICK : EDGE,
                                          quick ? DIRECTIONS_QUICK : DIRECTIONS, setting->thickness, &box);
    if (result != TY_OK) return result;
    box.def.accelerated = setting->accelerated;
    box.def.sweeps = quick ? SWEEPS_QUICK : SWEEPS;
    box.def.progress = cli_progress_report;
    box.def.progress_user = &run->session->progress;
    result = ordinates_box_solve(run->session->context, &box, history, history != NULL ? SWEEPS : 0, stats);
    ordinates_box_close(&box);
    return result;
}

static void name_series(plot_series* series, const solve_setting* setting) {
    snprintf(series->name, sizeof series->name, "%s, %s", ordinates_box_names[setting->kind],
             setting->accelerated ? "with diffusion" : "source iteration");
    series->style = setting->accelerated ? PLOT_LINE_AND_DOTS : PLOT_DASHES;
}

static void note_solve(figure_run* run, const solve_setting* setting, const ty_ordinates_stats* stats) {
    char item[FIGURE_NAME_SIZE];
    const bool checked = setting->accelerated && !run->options->quick;
    snprintf(item, sizeof item, "%s, thickness %g, %s", ordinates_box_names[setting->kind], setting->thickness,
             setting->accelerated ? "diffusion" : "source iteration");
    figure_expect(run, item, "converged", "1", stats->converged ? 1 : 0, setting->accelerated ? 1 : NAN,
                  setting->accelerated ? 0 : NAN);
    figure_expect(run, item, "sweeps", "1", stats->sweeps, checked ? 10 : NAN, checked ? 10 : NAN);
    figure_note(run, item, "time", "s", stats->seconds);
}

/* Without acceleration, every medium thicker than one that exceeded the limit of sweeps exceeds it, too. */
static ty_result fill_series(figure_run* run, ordinates_box_kind kind, bool accelerated, plot_series* series) {
    ty_result result = TY_OK;
    bool converges = true;
    for (int i = 0; i < THICKNESSES && result == TY_OK && (accelerated || converges); ++i) {
        const solve_setting setting = {kind, pow(10, 0.5 * i), accelerated};
        ty_ordinates_stats stats;
        name_series(series, &setting);
        result = solve(run, &setting, NULL, &stats);
        if (result == TY_OK) note_solve(run, &setting, &stats);
        if (result != TY_OK) return result;
        converges = stats.converged;
        if (converges) plot_add_point(series, setting.thickness, stats.sweeps, 0);
    }
    return result;
}

/* The remaining error after each sweep. */
static ty_result fill_history(figure_run* run, double thickness, bool accelerated, plot_series* series) {
    const solve_setting setting = {ORDINATES_BOX_CLOUD, thickness, accelerated};
    ty_ordinates_stats stats;
    double* history = calloc(SWEEPS, sizeof *history);
    if (history == NULL) return TY_ERROR_MEMORY;
    const ty_result result = solve(run, &setting, history, &stats);
    const int32_t count = result == TY_OK ? stats.sweeps : 0;
    snprintf(series->name, sizeof series->name, "%g, %s", thickness,
             accelerated ? "with diffusion" : "source iteration");
    series->style = accelerated ? PLOT_LINE_AND_DOTS : PLOT_DASHES;
    int32_t last = 0;
    for (int i = 0; i < HISTORY_DOTS && count > 0; ++i) {
        const int32_t sweep = (int32_t)lround(pow(count, (double)i / (HISTORY_DOTS - 1)));
        if (sweep > last) plot_add_point(series, sweep, history[sweep - 1], 0);
        last = sweep;
    }
    free(history);
    return result;
}

static ty_result fill_charts(figure_run* run, plot_chart charts[CHARTS]) {
    ty_result result = TY_OK;
    for (int kind = 0; kind < ORDINATES_BOX_KINDS; ++kind)
        for (int plain = 0; plain < 2 && result == TY_OK; ++plain) {
            plot_series* series = &charts[0].series[charts[0].series_count++];
            series->color = 1 + kind;
            result = fill_series(run, (ordinates_box_kind)kind, plain == 0, series);
        }
    for (int i = 0; i < HISTORIES; ++i)
        for (int plain = 0; plain < 2 && result == TY_OK; ++plain) {
            plot_series* series = &charts[1].series[charts[1].series_count++];
            series->color = 1 + i;
            result = fill_history(run, history_thickness[i], plain == 0, series);
        }
    return result;
}

ty_result figure_dom_convergence(figure_run* run) {
    static plot_chart charts[CHARTS];
    charts[0] = (plot_chart){.title = "sweeps until 10⁻³ is to come",
                             .x_label = "optical thickness",
                             .y_label = "sweeps",
                             .x_logarithmic = true,
                             .y_logarithmic = true};
    charts[1] = (plot_chart){.title = "cloud, by its thickness",
                             .x_label = "sweeps",
                             .y_label = "fluence that is to come, rms",
                             .x_logarithmic = true,
                             .y_logarithmic = true};
    const ty_result result = fill_charts(run, charts);
    if (result == TY_OK) plot_page_charts(&run->page, charts, CHARTS);
    figure_caption(
        run,
        "%d³ cells, %d directions, isotropic. Even: a cube that scatters and glows, nothing absorbed. Cloud: a lumpy "
        "ball in vacuum of albedo 0.999. Solves that take more than %d sweeps, or that rounding stops, are left out.",
        run->options->quick ? EDGE_QUICK : EDGE, run->options->quick ? DIRECTIONS_QUICK : DIRECTIONS,
        run->options->quick ? SWEEPS_QUICK : SWEEPS);
    return result;
}
