/* Energy balance per iteration: in the lattice, escaped, absorbed, blocked; and the balance of in-scattering as printed
 * in the paper. */
#include "base/constants.h"
#include "figures/view.h"
#include "method/lpv/propagate/transfer.h"

#include <math.h>
#include <string.h>

enum { MODES = 2, DEPTHS = 5, ITERATIONS = 8, CHARTS = 3 };

static const char* const mode_names[MODES] = {"links", "published"};
static const double depths[DEPTHS] = {0, 0.1, 1, 3, 10}; /* optical thickness of a cell */
static const double cell = 0.5;                          /* m */

/* A point light in fog, and a small tile lit by it. parts: flags of TY_LPV_ALL. */
static ty_result solve(figure_run* run, const ty_scene* scene, int mode, uint32_t parts, int32_t iterations,
                       ty_lpv_stats* stats) {
    ty_lpv* light = NULL;
    char options[64];
    ty_lpv_def def;
    snprintf(options, sizeof options, "mode=%s iterations=%d", mode_names[mode], (int)iterations);
    ty_result result = figure_method_def(scene, &ty_method_lpv, options, &def);
    def.parts = parts;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    if (result == TY_OK) result = ty_lpv_solve(scene, &def, &light, stats);
    ty_lpv_destroy(light);
    return result;
}

static double injected(const ty_lpv_stats* stats) {
    return stats->reflected[1] + stats->scattered[1];
}

/* Energy relative to the injected energy. */
static double accounted(const ty_lpv_stats* stats) {
    return (stats->absorbed[1] + stats->blocked[1] + stats->escaped[1] + stats->left[1]) / injected(stats);
}

/* Light reflected by surfaces and light scattered by fog, separately. */
static ty_result note_components(figure_run* run, const char* item, const ty_scene* scene, int mode) {
    static const struct {
        uint32_t part;
        const char* name;
    } sources[2] = {{TY_LPV_REFLECTED, "of reflected light alone, accounted for"},
                    {TY_LPV_SCATTERED, "of scattered light alone, accounted for"}};
    ty_result result = TY_OK;
    for (int i = 0; i < 2 && result == TY_OK; ++i) {
        ty_lpv_stats stats = ty_default_lpv_stats();
        result = solve(run, scene, mode, TY_LPV_SCATTERING | sources[i].part, ITERATIONS, &stats);
        if (result == TY_OK && injected(&stats) > 0)
            figure_expect(run, item, sources[i].name, "1", accounted(&stats), 1, 0.03);
    }
    return result;
}

static ty_result add_series(figure_run* run, const ty_scene* scene, int mode, int depth, plot_chart* charts) {
    char item[FIGURE_NAME_SIZE];
    plot_series *sum = &charts[0].series[charts[0].series_count++], *left = &charts[1].series[charts[1].series_count++];
    ty_lpv_stats stats = ty_default_lpv_stats();
    double worst = 0;
    ty_result result = TY_OK;
    snprintf(item, sizeof item, "%s, σt d = %g", mode_names[mode], depths[depth]);
    snprintf(sum->name, PLOT_LABEL_SIZE, "%s", item);
    snprintf(left->name, PLOT_LABEL_SIZE, "%s", item);
    sum->color = left->color = 1 + depth;
    sum->style = left->style = mode == 0 ? PLOT_LINE_AND_DOTS : PLOT_DASHES;
    for (int32_t i = 1; i <= ITERATIONS && result == TY_OK; ++i) {
        result = solve(run, scene, mode, TY_LPV_ALL, i, &stats);
        worst = fmax(worst, fabs(accounted(&stats) - 1) / i);
        plot_add_point(sum, i, accounted(&stats), 0);
        plot_add_point(left, i, stats.left[1] / injected(&stats), 0);
    }
    if (result == TY_OK)
        figure_expect(run, item, "energy accounted for after 8 iterations", "1", accounted(&stats), 1, 0.03);
    if (result == TY_OK)
        figure_expect(run, item, "energy lost or gained in an iteration, at most", "1", worst, 0, 0.01);
    if (result == TY_OK) result = note_components(run, item, scene, mode);
    return result;
}

/* The ratio of in-scattered to out-scattered energy with gamma_j = <G_j|1> / sum_l <G_l|1> as printed in the paper: the
 * in-scattered energy is sum_j gamma_j <G_j|1>, and sum_j G_j0^2 = 1. */
static double printed_fraction(void) {
    ty_lpv_transfer transfer;
    double sum = 0;
    ty_lpv_transfer_make(2, false, &transfer);
    for (int j = 0; j < TY_LPV_LINKS; ++j) sum += (double)transfer.G[j][0];
    return TY_SQRT_4PI_F64 / sum;
}

/* The remaining energy in an infinite lattice. */
static void add_printed(figure_run* run, plot_chart* chart) {
    const double fraction = printed_fraction();
    for (int d = 0; d < DEPTHS; ++d) {
        const double scattered = 1 - exp(-depths[d]);
        plot_series* series = &chart->series[chart->series_count++];
        snprintf(series->name, PLOT_LABEL_SIZE, "σt d = %g", depths[d]);
        series->color = 1 + d;
        for (int i = 1; i <= ITERATIONS; ++i)
            plot_add_point(series, i, pow(1 - scattered + fraction * scattered, i), 0);
    }
    figure_expect(run, "printed gamma", "in-scattered over out-scattered", "1", fraction, 0.696, 0.005);
}

static ty_result fill_charts(figure_run* run, plot_chart* charts) {
    ty_result result = TY_OK;
    add_printed(run, &charts[2]);
    for (int depth = 0; depth < DEPTHS && result == TY_OK; depth += run->options->quick ? DEPTHS - 1 : 1) {
        char override[48];
        const char* const overrides[1] = {override};
        ty_scene* scene = NULL;
        snprintf(override, sizeof override, "media[0].sigma_s=%g", depths[depth] / cell);
        result = figure_load_scene(run, "lpv_spot_on_tile", overrides, 1, &scene);
        for (int mode = 0; mode < MODES && result == TY_OK; ++mode)
            result = add_series(run, scene, mode, depth, charts);
        ty_scene_destroy(scene);
    }
    return result;
}

ty_result figure_lpv_energy(figure_run* run) {
    static plot_chart charts[CHARTS];
    charts[0] = (plot_chart){.title = "in the lattice, gone out or absorbed, of what came in",
                             .x_label = "iterations",
                             .y_label = "fraction",
                             .height = 330};
    charts[1] = (plot_chart){.title = "still in the lattice, of what came in",
                             .x_label = "iterations",
                             .y_label = "fraction",
                             .height = 330};
    charts[2] = (plot_chart){.title = "left by in-scattering as printed, without faces",
                             .x_label = "iterations",
                             .y_label = "fraction",
                             .height = 330};
    const ty_result result = fill_charts(run, charts);
    if (result == TY_OK) plot_page_charts(&run->page, charts, CHARTS);
    figure_caption(run, "A lamp and a tile in fog of albedo 1 on 16³ cells, for optical thicknesses of a cell from 0 "
                        "to 10. Right: what would be left in a lattice without end if light were scattered in with "
                        "gamma as the paper prints it, which gives back less than scattering out takes away.");
    return result;
}
