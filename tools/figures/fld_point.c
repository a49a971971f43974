/* Figs. 3 and 5 of the paper: a point source in a homogeneous medium, by theory and by the diffusion solver. */
#include "figures/figure.h"
#include "figures/fld_limiters.h"
#include "figures/fld_point_solve.h"
#include "figures/point_transport.h"

#include <math.h>

enum { ALBEDOS = 7, CELLS = 127, CELLS_QUICK = 31, DOTS = 13, LINE_POINTS = 48, FIRST_CELL = 4 };

static const double albedos[ALBEDOS] = {0, 0.2, 0.4, 0.6, 0.8, 0.9, 1};
/* Cells along an edge whose fluence is shown. */
static const int32_t shown[DOTS] = {1, 2, 3, 4, 6, 8, 11, 15, 21, 29, 40, 50, 62};
/* Ranges of errors and slopes, mean free paths. */
static const double near_from = 0.1, near_to = 0.3, thin_to = 1;

/* The charts: theory, and solvers below. */
typedef enum panel { TRANSPORT, DIFFUSION, KNUDSEN, CDA_KNOWN, CDA_ZERO, FLD_ZERO, PANELS } panel;

typedef double (*point_theory)(double albedo, double tau);

/* Errors of one albedo's solves against transport where tau < 1, by limiter. */
typedef struct point_row {
    double errors[TY_LIMITER_COUNT], slopes[TY_LIMITER_COUNT];
    double theory_error; /* of Eq. 27 */
} point_row;

/* ---- charts ---- */

static void begin_charts(plot_chart charts[PANELS]) {
    static const char* const titles[PANELS] = {
        "3a  transport: exact, Grosjean (dashed)", "3b  classical diffusion",
        "3c  Knudsen number of Grosjean's",        "5a  CDA, its own fluence on the faces",
        "5b  CDA, no fluence on the faces",        "5c  FLD over exact transport"};
    for (int i = 0; i < PANELS; ++i)
        charts[i] = (plot_chart){.title = titles[i],
                                 .x_label = "optical depth τ",
                                 .y_label = i == KNUDSEN ? "R" : "normalised fluence",
                                 .x_logarithmic = true,
                                 .y_logarithmic = true,
                                 .width = 360,
                                 .height = 300};
}

static plot_series* add_series(plot_chart* chart, int albedo, plot_style style) {
    plot_series* series = &chart->series[chart->series_count++];
    series->style = style;
    series->color = albedo + 1;
    return series;
}

static void add_curve(plot_chart* chart, int albedo, plot_style style, point_theory theory, bool named) {
    plot_series* series = add_series(chart, albedo, style);
    if (named) snprintf(series->name, sizeof series->name, "albedo %g", albedos[albedo]);
    for (int i = 0; i < LINE_POINTS; ++i) {
        const double tau = 0.03 * pow(100, (double)i / (LINE_POINTS - 1));
        plot_add_point(series, tau, theory(albedos[albedo], tau), 0);
    }
}

static void add_curves(plot_chart charts[PANELS], int albedo) {
    add_curve(&charts[TRANSPORT], albedo, PLOT_LINE, transport_fluence, false);
    add_curve(&charts[TRANSPORT], albedo, PLOT_DASHES, transport_grosjean, false);
    add_curve(&charts[DIFFUSION], albedo, PLOT_LINE, transport_diffusion, false);
    add_curve(&charts[KNUDSEN], albedo, PLOT_LINE, transport_grosjean_knudsen, true);
    add_curve(&charts[CDA_KNOWN], albedo, PLOT_LINE, transport_diffusion, false);
    add_curve(&charts[CDA_ZERO], albedo, PLOT_LINE, transport_diffusion, false);
    add_curve(&charts[FLD_ZERO], albedo, PLOT_LINE, transport_fluence, true);
}

/* ---- solves ---- */

static ty_result solve(figure_run* run, int albedo, ty_limiter limiter, bool diffusive_faces, point_profile* profile) {
    const point_case which = {run->options->quick ? CELLS_QUICK : CELLS, albedos[albedo], limiter, diffusive_faces};
    return point_solve(run->session->context, &which, cli_progress_report, &run->session->progress, profile);
}

/* Adds dots to a chart and records their numbers: cells along an edge, the first in the profile. */
static void show_profile(figure_run* run, const point_profile* profile, int albedo, const char* item,
                         point_theory theory, plot_chart* chart) {
    plot_series* series = add_series(chart, albedo, PLOT_DOTS);
    for (int i = 0; i < DOTS; ++i) {
        if (shown[i] > profile->count / POINT_DIRECTIONS) break;
        char name[FIGURE_NAME_SIZE];
        const point_sample* sample = &profile->samples[shown[i] - 1];
        snprintf(name, sizeof name, "normalised fluence, tau %.4g", sample->tau);
        plot_add_point(series, sample->tau, sample->fluence, 0);
        figure_expect(run, item, name, "1", sample->fluence, theory(albedos[albedo], sample->tau), NAN);
    }
}

/* CDA with its analytic fluence on the faces reproduces its Green's function. */
static ty_result check_diffusion(figure_run* run, int albedo, point_profile* profile, plot_chart* chart) {
    char item[FIGURE_NAME_SIZE];
    snprintf(item, sizeof item, "albedo %g, CDA, Eq. 27 on the faces", albedos[albedo]);
    ty_result result = solve(run, albedo, TY_LIMITER_NONE, true, profile);
    if (result != TY_OK) return result;
    const double from = (FIRST_CELL - 0.1) * profile->samples[0].tau;
    const point_difference off = point_compare(profile, transport_diffusion, albedos[albedo], from, POINT_EXTENT);
    figure_expect(run, item, "largest error to Eq. 27, from 4 cells on", "1", off.largest, 0, 0.03);
    figure_note(run, item, "mean error to Eq. 27, from 4 cells on", "1", off.mean);
    show_profile(run, profile, albedo, item, transport_diffusion, chart);
    return TY_OK;
}

static ty_result note_limiter(figure_run* run, int albedo, ty_limiter limiter, const point_profile* profile,
                              const char* item, point_row* row) {
    const bool coarse = run->options->quick;
    const point_difference off = point_compare(profile, transport_fluence, albedos[albedo], near_from, thin_to);
    row->errors[limiter] = off.mean;
    row->slopes[limiter] = point_slope(profile, near_from, near_to);
    ty_result result = TY_OK;
    figure_notes(run, item, {"mean error to transport, tau 0.1 to 1", "1", off.mean},
                 {"largest error to transport, tau 0.1 to 1", "1", off.largest});
    const bool expected = limiter == TY_LIMITER_LEVERMORE_POMRANING && !coarse;
    figure_expect(run, item, "slope, tau 0.1 to 0.3", "1", row->slopes[limiter], expected ? -2 : NAN,
                  expected ? 0.2 : NAN);
    if (result == TY_OK && limiter == TY_LIMITER_LEVERMORE_POMRANING)
        figure_expect(run, item, "mean error over CDA's", "1", off.mean / row->errors[TY_LIMITER_NONE],
                      coarse ? NAN : 0, coarse ? NAN : 1);
    figure_notes(run, item, {"iterations", "1", profile->stats.iterations}, {"seconds", "s", profile->stats.seconds});
    return TY_OK;
}

static ty_result run_limiter(figure_run* run, int albedo, ty_limiter limiter, point_profile* profile,
                             plot_chart charts[PANELS], point_row* row) {
    char item[FIGURE_NAME_SIZE];
    snprintf(item, sizeof item, "albedo %g, %s, 0 on the faces", albedos[albedo], fld_limiter_names[limiter]);
    ty_result result = solve(run, albedo, limiter, false, profile);
    if (result == TY_OK) result = note_limiter(run, albedo, limiter, profile, item, row);
    if (result == TY_OK && limiter == TY_LIMITER_NONE)
        show_profile(run, profile, albedo, item, transport_diffusion, &charts[CDA_ZERO]);
    if (result == TY_OK && limiter == TY_LIMITER_LEVERMORE_POMRANING)
        show_profile(run, profile, albedo, item, transport_fluence, &charts[FLD_ZERO]);
    return result;
}

/* The error of Eq. 27 itself, at the cells of a profile. */
static double theory_error_of(point_profile* profile, int albedo) {
    for (int32_t i = 0; i < profile->count; ++i)
        profile->samples[i].fluence = transport_diffusion(albedos[albedo], profile->samples[i].tau);
    return point_compare(profile, transport_fluence, albedos[albedo], near_from, thin_to).mean;
}

static ty_result run_albedo(figure_run* run, int albedo, point_profile* profile, plot_chart charts[PANELS],
                            point_row* row) {
    add_curves(charts, albedo);
    ty_result result = check_diffusion(run, albedo, profile, &charts[CDA_KNOWN]);
    for (ty_limiter limiter = 0; limiter < TY_LIMITER_COUNT && result == TY_OK; ++limiter)
        result = run_limiter(run, albedo, limiter, profile, charts, row);
    if (result == TY_OK) row->theory_error = theory_error_of(profile, albedo);
    return result;
}

/* ---- the page ---- */

static ty_result fill_table(figure_run* run, const point_row rows[ALBEDOS]) {
    plot_table table;
    const ty_result result = plot_create_table(2 + ALBEDOS, 4 + TY_LIMITER_COUNT, 2, &table);
    if (result != TY_OK) return result;
    plot_set_cell(&table, 0, 0, "mean error to exact transport, τ = 0.1 to 1");
    plot_set_cell(&table, 0, 2 + TY_LIMITER_COUNT, "slope, τ = 0.1 to 0.3");
    plot_set_cell(&table, 1, 1, "Eq. 27");
    plot_set_cell(&table, 1, 2 + TY_LIMITER_COUNT, "CDA");
    plot_set_cell(&table, 1, 3 + TY_LIMITER_COUNT, "Levermore-Pomraning");
    for (int limiter = 0; limiter < TY_LIMITER_COUNT; ++limiter)
        plot_set_cell(&table, 1, 2 + limiter, "%s", fld_limiter_names[limiter]);
    for (int i = 0; i < ALBEDOS; ++i) {
        plot_set_cell(&table, 2 + i, 0, "albedo %g", albedos[i]);
        plot_set_cell(&table, 2 + i, 1, "%.1f %%", 100 * rows[i].theory_error);
        for (int limiter = 0; limiter < TY_LIMITER_COUNT; ++limiter)
            plot_set_cell(&table, 2 + i, 2 + limiter, "%.1f %%", 100 * rows[i].errors[limiter]);
        plot_set_cell(&table, 2 + i, 2 + TY_LIMITER_COUNT, "%.2f", rows[i].slopes[TY_LIMITER_NONE]);
        plot_set_cell(&table, 2 + i, 3 + TY_LIMITER_COUNT, "%.2f", rows[i].slopes[TY_LIMITER_LEVERMORE_POMRANING]);
    }
    plot_page_table(&run->page, &table);
    plot_free_table(&table);
    return TY_OK;
}

static void write_caption(figure_run* run) {
    const int cells = run->options->quick ? CELLS_QUICK : CELLS;
    figure_caption(
        run,
        "A cell that emits unit power in a homogeneous cube of %d³ cells, 4 mean free paths across. Lines are theory "
        "(exact transport by Case and Zweifel's integral), dots the solver's fluence along an edge, times 4π/σt². "
        "Errors and slopes are over cells along an edge and both diagonals, with no fluence on the faces.",
        cells);
}

ty_result figure_fld_point(figure_run* run) {
    static plot_chart charts[PANELS];
    static point_profile profile;
    point_row rows[ALBEDOS] = {0};
    ty_result result = TY_OK;
    begin_charts(charts);
    for (int albedo = 0; albedo < ALBEDOS && result == TY_OK; ++albedo)
        result = run_albedo(run, albedo, &profile, charts, &rows[albedo]);
    if (result == TY_OK) {
        plot_page_charts(&run->page, charts, 3);
        plot_page_charts(&run->page, charts + CDA_KNOWN, 3);
        result = fill_table(run, rows);
    }
    write_caption(run);
    return result;
}
