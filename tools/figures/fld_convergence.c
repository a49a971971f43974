/* Fig. 4 of the paper: convergence of the solvers. */
#include "figures/figure.h"
#include "bench/fld_box.h"

#include <math.h>
#include <stdlib.h>

enum {
    NAME_SIZE = 32,
    OMEGAS = 5,
    CELLS = 51, /* value of the paper */
    CELLS_QUICK = 15,
    HISTORY = 3000,
    HISTORY_DOTS = 56,
    MULTIGRID_DOTS = 20,
    SIZES = 7,
    SIZES_OF_SOR = 5,
    SIZES_QUICK = 2,
    NOISE = 64
};

/* Over-relaxation factors: all for Fig. 4a, the third and fourth against resolution. */
static const double omegas[OMEGAS] = {1, 1.3, 1.6, 1.8, 1.9};
enum { OMEGA_FIRST = 2, OMEGA_LAST = 3 };
static const int32_t sizes[SIZES] = {16, 24, 32, 48, 64, 96, 128};
static const double tolerance = 1e-6;

/* The medium: a ball in vacuum, in a cube of edges of 1 m. */
static const float extinction = 20, absorption = 2; /* 1/m */
static const double radius = 0.4;                   /* m */

/* ---- the paper's test case ---- */

/* Emission of the ball is noise, the same for any number of cells. */
static ty_result make_ball(figure_run* run, const ty_grid* noise, int32_t edge, fld_box* out) {
    const ty_result result = fld_make_box(run->session->context, edge, 1, out);
    if (result != TY_OK) return result;
    for (int32_t z = 0; z < edge; ++z)
        for (int32_t y = 0; y < edge; ++y)
            for (int32_t x = 0; x < edge; ++x) {
                const double at[3] = {(x + 0.5) / edge, (y + 0.5) / edge, (z + 0.5) / edge};
                if (hypot(hypot(at[0] - 0.5, at[1] - 0.5), at[2] - 0.5) > radius) continue;
                const double voxel[3] = {at[0] * NOISE - 0.5, at[1] * NOISE - 0.5, at[2] * NOISE - 0.5};
                const size_t i = fld_box_at(out, x, y, z);
                out->extinction[i] = extinction;
                out->absorption[i] = absorption;
                out->source[i] = ty_grid_sample(noise, voxel);
            }
    out->def.tolerance = tolerance;
    out->def.progress = cli_progress_report;
    out->def.progress_user = &run->session->progress;
    return TY_OK;
}

static ty_result make_noise(figure_run* run, ty_grid** out) {
    ty_noise_def def = ty_default_noise_def();
    def.kind = TY_NOISE_FBM;
    for (int axis = 0; axis < 3; ++axis) def.size[axis] = NOISE;
    def.octaves = 3;
    def.sharpness = 1;
    return ty_grid_create_noise(run->session->context, &def, out);
}

static ty_result solve(figure_run* run, fld_box* box, double* history, ty_diffusion_stats* stats) {
    const ty_diffusion_out out = {
        .fluence = box->fluence, .history = history, .history_capacity = history != NULL ? HISTORY : 0};
    return ty_diffusion_solve(run->session->context, &box->def, &out, stats);
}

static void name_solver(int omega, char name[NAME_SIZE]) {
    if (omega < 0)
        snprintf(name, NAME_SIZE, "multigrid");
    else
        snprintf(name, NAME_SIZE, "SOR, omega %g", omegas[omega]);
}

/* omega < 0: multigrid. */
static void choose_solver(fld_box* box, int omega) {
    box->def.solver = omega < 0 ? TY_DIFFUSION_MULTIGRID : TY_DIFFUSION_SOR;
    box->def.iterations = omega < 0 ? 0 : HISTORY;
    if (omega >= 0) box->def.relaxation = omegas[omega];
}

static void note_solve(figure_run* run, int omega, int32_t edge, const ty_diffusion_stats* stats) {
    char name[NAME_SIZE], item[FIGURE_NAME_SIZE];
    name_solver(omega, name);
    snprintf(item, sizeof item, "%s, %d^3 cells", name, (int)edge);
    figure_notes(run, item, {"converged", "1", stats->converged ? 1 : 0}, {"iterations", "1", stats->iterations},
                 {"work, passes over all cells", "1", stats->work}, {"residual", "1", stats->residual},
                 {"time", "s", stats->seconds});
}

/* ---- (a) ---- */

/* Residuals of over-relaxation, one pass over all cells per iteration; dots at equal ratios. */
static ty_result follow_sor(figure_run* run, fld_box* box, int omega, plot_series* series) {
    ty_diffusion_stats stats;
    double* history = malloc(HISTORY * sizeof *history);
    if (history == NULL) return TY_ERROR_MEMORY;
    choose_solver(box, omega);
    ty_result result = solve(run, box, history, &stats);
    int32_t last = 0;
    for (int i = 0; i < HISTORY_DOTS && result == TY_OK; ++i) {
        const int32_t pass = (int32_t)lround(pow(stats.history_count, (double)i / (HISTORY_DOTS - 1)));
        if (pass > last) plot_add_point(series, pass, history[pass - 1], 0);
        last = pass;
    }
    free(history);
    if (result == TY_OK) note_solve(run, omega, box->edge, &stats);
    return result;
}

/* Residuals of multigrid over its work, each from a separate solve. */
static ty_result follow_multigrid(figure_run* run, fld_box* box, plot_series* series) {
    ty_diffusion_stats complete, partial;
    choose_solver(box, -1);
    ty_result result = solve(run, box, NULL, &complete);
    int32_t last = 0;
    for (int i = 0; i < MULTIGRID_DOTS && result == TY_OK; ++i) {
        const int32_t iterations = (int32_t)lround(pow(complete.iterations, (double)i / (MULTIGRID_DOTS - 1)));
        if (iterations == last) continue;
        last = box->def.iterations = iterations;
        result = solve(run, box, NULL, &partial);
        if (result == TY_OK) plot_add_point(series, partial.work, partial.residual, 0);
    }
    if (result == TY_OK) note_solve(run, -1, box->edge, &complete);
    return result;
}

static ty_result fill_histories(figure_run* run, const ty_grid* noise, plot_chart* chart) {
    fld_box box;
    ty_result result = make_ball(run, noise, run->options->quick ? CELLS_QUICK : CELLS, &box);
    if (result != TY_OK) return result;
    for (int omega = -1; omega < OMEGAS && result == TY_OK; ++omega) {
        char name[NAME_SIZE];
        plot_series* series = &chart->series[chart->series_count++];
        name_solver(omega, name);
        snprintf(series->name, sizeof series->name, "%s", name);
        series->style = omega < 0 ? PLOT_LINE_AND_DOTS : PLOT_LINE;
        result = omega < 0 ? follow_multigrid(run, &box, series) : follow_sor(run, &box, omega, series);
    }
    fld_free_box(run->session->context, &box);
    return result;
}

/* ---- (b) ---- */

static ty_result solve_size(figure_run* run, const ty_grid* noise, int size, int omega, plot_chart charts[2]) {
    fld_box box;
    ty_diffusion_stats stats;
    ty_result result = make_ball(run, noise, sizes[size], &box);
    if (result != TY_OK) return result;
    choose_solver(&box, omega);
    result = solve(run, &box, NULL, &stats);
    fld_free_box(run->session->context, &box);
    if (result == TY_OK) note_solve(run, omega, sizes[size], &stats);
    if (result != TY_OK || !stats.converged) return result;
    const int series = omega < 0 ? 0 : 1 + omega - OMEGA_FIRST;
    plot_add_point(&charts[0].series[series], sizes[size], stats.iterations, 0);
    if (omega < 0) plot_add_point(&charts[0].series[OMEGA_LAST - OMEGA_FIRST + 2], sizes[size], stats.work, 0);
    plot_add_point(&charts[1].series[series], sizes[size], stats.seconds, 0);
    return result;
}

static ty_result fill_sizes(figure_run* run, const ty_grid* noise, plot_chart charts[2]) {
    ty_result result = TY_OK;
    for (int chart = 0; chart < 2; ++chart) charts[chart].series_count = OMEGA_LAST - OMEGA_FIRST + 2;
    for (int omega = -1; omega <= OMEGA_LAST && result == TY_OK; omega = omega < 0 ? OMEGA_FIRST : omega + 1) {
        const int count = run->options->quick ? SIZES_QUICK : omega < 0 ? SIZES : SIZES_OF_SOR;
        char name[NAME_SIZE];
        name_solver(omega, name);
        for (int chart = 0; chart < 2; ++chart)
            snprintf(charts[chart].series[omega < 0 ? 0 : 1 + omega - OMEGA_FIRST].name, PLOT_LABEL_SIZE, "%s", name);
        for (int size = 0; size < count && result == TY_OK; ++size)
            result = solve_size(run, noise, size, omega, charts);
    }
    plot_series* work = &charts[0].series[charts[0].series_count++];
    snprintf(work->name, sizeof work->name, "multigrid, work");
    work->style = PLOT_DASHES;
    work->color = 1;
    return result;
}

/* ---- (c) ---- */

/* Minimum extinctions per box length, and the solvers that use them. */
enum { MIN_EXTINCTIONS = 6, SETUPS = 3, VOXELS = 100, VOXELS_QUICK = 32, RATIO = 4 };
static const double min_extinctions[MIN_EXTINCTIONS] = {1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5};
static const struct {
    const char* name;
    ty_fld_solver solver;
    double omega;
} setups[SETUPS] = {{"multigrid", TY_FLD_SOLVER_MULTIGRID, 1},
                    {"SOR, omega 1.3, single", TY_FLD_SOLVER_SOR_FLOAT, 1.3},
                    {"SOR, omega 1.6, single", TY_FLD_SOLVER_SOR_FLOAT, 1.6}};

static ty_result solve_nebula(figure_run* run, const ty_scene* scene, int setup, int index, plot_series* series) {
    char item[FIGURE_NAME_SIZE];
    ty_fld* light = NULL;
    ty_fld_stats stats = ty_default_fld_stats();
    ty_fld_def def = ty_default_fld_def();
    def.ratio = RATIO;
    def.boundary = TY_FLD_BOUNDARY_DIRICHLET;
    def.solver = setups[setup].solver;
    def.relaxation = setups[setup].omega;
    def.iterations = HISTORY;
    def.sigma_eps = min_extinctions[index];
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    ty_result result = ty_fld_solve(scene, &def, &light, &stats);
    ty_fld_destroy(light);
    if (result != TY_OK) return result;
    snprintf(item, sizeof item, "nebulae, %s, sigma_eps L %g", setups[setup].name, min_extinctions[index]);
    figure_notes(run, item, {"converged", "1", stats.converged ? 1 : 0},
                 {"iterations, green", "1", stats.iterations[1]}, {"time", "s", stats.solve_seconds});
    if (stats.converged) plot_add_point(series, min_extinctions[index], stats.iterations[1], 0);
    return TY_OK;
}

static ty_result fill_min_extinctions(figure_run* run, plot_chart* chart) {
    char voxels[64];
    const char* const overrides[1] = {voxels};
    ty_scene* scene = NULL;
    snprintf(voxels, sizeof voxels, "media[0].density.noise.resolution=%d",
             run->options->quick ? VOXELS_QUICK : VOXELS);
    ty_result result = ty_scene_load(run->session->context, "builtin:nebulae", overrides, 1, &scene);
    chart->series_count = SETUPS;
    for (int setup = 0; setup < SETUPS && result == TY_OK; ++setup) {
        snprintf(chart->series[setup].name, PLOT_LABEL_SIZE, "%s", setups[setup].name);
        for (int index = 0; index < MIN_EXTINCTIONS && result == TY_OK; ++index)
            result = solve_nebula(run, scene, setup, index, &chart->series[setup]);
    }
    ty_scene_destroy(scene);
    return result;
}

/* ---- the page ---- */

enum { CHARTS = 4 };

static void begin_charts(plot_chart charts[CHARTS]) {
    charts[0] = (plot_chart){
        .title = "4a  residuals", .x_label = "work, passes over all cells", .y_label = "rms residual / rms source"};
    charts[1] = (plot_chart){.title = "4b  until 10⁻⁶", .x_label = "cells along an edge", .y_label = "iterations"};
    charts[2] = (plot_chart){.title = "time until 10⁻⁶", .x_label = "cells along an edge", .y_label = "s"};
    charts[3] =
        (plot_chart){.title = "4c  nebulae, until 10⁻⁴", .x_label = "minimum extinction, 1/m", .y_label = "iterations"};
    for (int chart = 0; chart < CHARTS; ++chart) charts[chart].x_logarithmic = charts[chart].y_logarithmic = true;
}

ty_result figure_fld_convergence(figure_run* run) {
    ty_grid* noise = NULL;
    static plot_chart charts[CHARTS];
    begin_charts(charts);
    ty_result result = make_noise(run, &noise);
    if (result == TY_OK) result = fill_histories(run, noise, &charts[0]);
    if (result == TY_OK) result = fill_sizes(run, noise, charts + 1);
    if (result == TY_OK) result = fill_min_extinctions(run, &charts[3]);
    if (result == TY_OK) plot_page_charts(&run->page, charts, 2);
    if (result == TY_OK) plot_page_charts(&run->page, charts + 2, 2);
    ty_grid_release(noise);
    figure_caption(run,
                   "(a), (b): a ball of extinction %g/m and albedo %g in vacuum, its emission noise, no fluence on the "
                   "faces of its cube of 1 m; %d³ cells in (a). Over-relaxation is Algorithm 1 in double precision, "
                   "one pass over all cells an iteration; multigrid's dashed line counts the passes of all its levels, "
                   "by their cells. (c): the builtin scene nebulae, 1 m across, on %d³ cells, green; solves that take "
                   "more than %d iterations are left out.",
                   (double)extinction, 1 - (double)absorption / (double)extinction,
                   run->options->quick ? CELLS_QUICK : CELLS, (run->options->quick ? VOXELS_QUICK : VOXELS) / RATIO,
                   HISTORY);
    return result;
}
