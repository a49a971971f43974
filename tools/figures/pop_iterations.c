/* Fig. 13 of the paper: convergence of the published propagation in the cube of Fig. 12. */
#include "figures/pop_cube.h"

enum { STEPS = 6, SAMPLES = 8192, ALONG = 16 };

static const int32_t steps[STEPS] = {1, 4, 16, 64, 256, 1024};

/* A central column of cells along the beam. */
static const fluence_box column = {{-0.0625, -0.0625, -0.5}, {0.0625, 0.0625, 0.5}, {1, 1, ALONG}};

static void add_series(plot_chart* chart, const char* name, const double (*fluence)[3], plot_style style) {
    plot_series* series = &chart->series[chart->series_count++];
    snprintf(series->name, PLOT_LABEL_SIZE, "%s", name);
    series->style = style;
    for (int i = 0; i < ALONG; ++i) plot_add_point(series, (ALONG - i - 0.5) / ALONG, fluence[i][1], 0);
}

/* Scattered fluence along the column. def NULL: by path tracing. */
static ty_result find_fluence(figure_run* run, const ty_scene* scene, const ty_pop_def* def, fluence_truth* out,
                              ty_pop_stats* stats) {
    ty_pop* light = NULL;
    if (def == NULL) return path_fluence(run, scene, &column, SAMPLES, out);
    ty_result result = ty_pop_solve(scene, def, &light, stats);
    if (result == TY_OK) result = pop_fluence(light, &column, out->scattered);
    ty_pop_destroy(light);
    return result;
}

static ty_result run_step(figure_run* run, const ty_scene* scene, int step, fluence_truth* fluence,
                          plot_chart charts[2]) {
    char item[FIGURE_NAME_SIZE];
    ty_pop_stats stats = ty_default_pop_stats();
    ty_pop_def def = pop_cube_def(run, TY_POP_MODE_PUBLISHED);
    def.iterations = steps[step];
    def.residuum = 0;
    snprintf(item, sizeof item, "%d iteration%s", (int)steps[step], steps[step] == 1 ? "" : "s");
    ty_result result = find_fluence(run, scene, &def, fluence, &stats);
    if (result == TY_OK)
        figure_notes(run, item, {"light not yet propagated", "1", stats.left},
                     {"time of propagation", "s", stats.propagation_seconds});
    if (result != TY_OK) return result;
    add_series(&charts[0], item, (const double(*)[3])fluence->scattered, PLOT_LINE_AND_DOTS);
    plot_add_point(&charts[1].series[0], steps[step], stats.left, 0);
    return TY_OK;
}

static ty_result fill_charts(figure_run* run, fluence_truth* fluence, plot_chart charts[2]) {
    ty_scene* scene = NULL;
    const ty_pop_def split = pop_cube_def(run, TY_POP_MODE_SPLIT);
    ty_pop_stats stats = ty_default_pop_stats();
    ty_result result = pop_load_cube(run, 0.7, &scene);
    if (result == TY_OK) result = find_fluence(run, scene, NULL, fluence, &stats);
    if (result == TY_OK) add_series(&charts[0], "path tracing", (const double(*)[3])fluence->scattered, PLOT_LINE);
    if (result == TY_OK) result = find_fluence(run, scene, &split, fluence, &stats);
    if (result == TY_OK) add_series(&charts[0], "split", (const double(*)[3])fluence->scattered, PLOT_DASHES);
    for (int step = 0; step < STEPS && result == TY_OK; ++step) result = run_step(run, scene, step, fluence, charts);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_pop_iterations(figure_run* run) {
    static plot_chart charts[2];
    static fluence_truth fluence;
    charts[0] = (plot_chart){.title = "light that has scattered, along the axis",
                             .x_label = "depth, m",
                             .y_label = "fluence, W/m²",
                             .y_logarithmic = true,
                             .height = 330};
    charts[1] = (plot_chart){.title = "light not yet propagated, of what came in",
                             .x_label = "iterations",
                             .y_label = "fraction",
                             .x_logarithmic = true,
                             .y_logarithmic = true,
                             .height = 330,
                             .series_count = 1};
    const ty_result result = fill_charts(run, &fluence, charts);
    if (result == TY_OK) plot_page_charts(&run->page, charts, 2);
    figure_caption(run, "The cube of Fig. 12 with g = 0.7: iterations of the published propagation on 16³ cells, "
                        "without the isotropic residuum. Their limit is many times path tracing's fluence: light "
                        "counts once for every cell that it came through, and is trapped by moving one cell a step.");
    return result;
}
