/* Thin to dense media: fluence around a point light in a cube of fog by both modes, against path tracing. */
#include "figures/view.h"

#include <math.h>

enum { DEPTHS = 4, MODES = 2, ALONG = 8, SAMPLES = 4096, SAMPLES_QUICK = 64 };

static const double depths[DEPTHS] = {0.1, 0.5, 2, 5}; /* optical thickness of a cell */
static const double cell = 0.5;                        /* m */
static const char* const modes[MODES] = {"links", "published"};

/* 17 cells along each side, the light in the central cell; albedo 1. */
/* Cells from the light's neighbor to the face. */
static const double lower[3] = {0.25, -0.25, -0.25}, upper[3] = {4.25, 0.25, 0.25};
static const int32_t size[3] = {ALONG, 1, 1};

/* Scattered fluence, green. */
static ty_result find_truth(figure_run* run, const ty_scene* scene, double fluence[ALONG]) {
    double total[ALONG][3], uncollided[ALONG][3];
    ty_path_def def = ty_default_path_def();
    def.spp = figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES);
    def.seed = run->session->common.seed;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    const ty_result result = ty_path_fluence(scene, &def, lower, upper, size, total[0], uncollided[0], NULL);
    for (int i = 0; i < ALONG && result == TY_OK; ++i) fluence[i] = total[i][1] - uncollided[i][1];
    return result;
}

static ty_result find_fluence(figure_run* run, const ty_scene* scene, const char* mode, double fluence[ALONG]) {
    ty_lpv* light = NULL;
    double all[ALONG][3];
    char options[32];
    ty_lpv_def def;
    snprintf(options, sizeof options, "mode=%s", mode);
    ty_result result = figure_method_def(scene, &ty_method_lpv, options, &def);
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    if (result == TY_OK) result = ty_lpv_solve(scene, &def, &light, NULL);
    if (result == TY_OK) result = ty_lpv_fluence(light, lower, upper, size, all[0]);
    for (int i = 0; i < ALONG && result == TY_OK; ++i) fluence[i] = all[i][1];
    ty_lpv_destroy(light);
    return result;
}

static void add_series(plot_chart* chart, const char* name, int depth, plot_style style, const double fluence[ALONG]) {
    plot_series* series = &chart->series[chart->series_count++];
    snprintf(series->name, PLOT_LABEL_SIZE, "%s, σt d = %g", name, depths[depth]);
    series->style = style;
    series->color = 1 + depth;
    for (int i = 0; i < ALONG; ++i) plot_add_point(series, lower[0] + (i + 0.5) * cell, fluence[i], 0);
}

static double sum_of(const double fluence[ALONG]) {
    double sum = 0;
    for (int i = 0; i < ALONG; ++i) sum += fluence[i];
    return sum;
}

static ty_result run_depth(figure_run* run, const ty_scene* scene, int depth, plot_chart* charts) {
    double truth[ALONG], fluence[ALONG];
    ty_result result = find_truth(run, scene, truth);
    for (int mode = 0; mode < MODES && result == TY_OK; ++mode) {
        char item[FIGURE_NAME_SIZE];
        double worst = 0;
        add_series(&charts[mode], "path tracing", depth, PLOT_LINE, truth);
        result = find_fluence(run, scene, modes[mode], fluence);
        if (result != TY_OK) return result;
        add_series(&charts[mode], modes[mode], depth, PLOT_DOTS, fluence);
        for (int i = 0; i < ALONG; ++i) worst = fmax(worst, fabs(fluence[i] / truth[i] - 1));
        snprintf(item, sizeof item, "%s, σt d = %g", modes[mode], depths[depth]);
        figure_expect(run, item, "mean ratio of fluence", "1", sum_of(fluence) / sum_of(truth), 1,
                      mode == 0 ? 0.2 : NAN);
        if (result == TY_OK) figure_note(run, item, "largest relative error of a cell", "1", worst);
    }
    return result;
}

ty_result figure_lpv_dense(figure_run* run) {
    static plot_chart charts[MODES];
    ty_result result = TY_OK;
    for (int mode = 0; mode < MODES; ++mode)
        charts[mode] = (plot_chart){.title = modes[mode],
                                    .x_label = "distance from the lamp, m",
                                    .y_label = "fluence of scattered light, W/m²",
                                    .y_logarithmic = true,
                                    .height = 360};
    for (int depth = 0; depth < DEPTHS && result == TY_OK; ++depth) {
        char override[48];
        const char* const overrides[1] = {override};
        ty_scene* scene = NULL;
        snprintf(override, sizeof override, "media[0].sigma_s=%g", depths[depth] / cell);
        result = figure_load_scene(run, "lpv_lamp_in_fog", overrides, 1, &scene);
        if (result == TY_OK) result = run_depth(run, scene, depth, charts);
        ty_scene_destroy(scene);
    }
    if (result == TY_OK) plot_page_charts(&run->page, charts, MODES);
    figure_caption(run, "A lamp at the center of a cube of fog of albedo 1, 17³ cells, whose optical thickness goes "
                        "from thin to dense: fluence of light that has scattered, from beside the lamp to a face.");
    return result;
}
