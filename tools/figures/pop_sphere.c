/* Fig. 10 of the paper: a point light at the center of a sphere, on radial grids. */
#include "figures/fluence.h"

#include <math.h>

enum {
    COSINES = 3,
    VARIANTS = 2,
    WIDTH = 200,
    PICTURE_WIDTH = 300,
    RADII = 20,
    EDGE = 8,
    SAMPLES = 256,
    RESOLUTION = 32
};

#define SPHERE(cosine)                                                                                                 \
    {                                                                                                                  \
        .title = "g = " #cosine, .item = "g " #cosine, .scene = "pop_sphere", .overrides = {"media[0].g=" #cosine},    \
        .width = WIDTH, .height = WIDTH                                                                                \
    }
static const figure_scene scenes[COSINES] = {SPHERE(0), SPHERE(0.5), SPHERE(0.9)};
static const ty_pop_mode modes[VARIANTS] = {TY_POP_MODE_SPLIT, TY_POP_MODE_PUBLISHED};
static const char* const mode_names[VARIANTS] = {"split", "published"};

/* A cube inside the sphere, and a radial line of cells, 0.1 m wide. */
static const fluence_box cube = {{-1.4, -1.4, -1.4}, {1.4, 1.4, 1.4}, {EDGE, EDGE, EDGE}};
static const fluence_box line = {{0, -0.05, -0.05}, {2.5, 0.05, 0.05}, {RADII, 1, 1}};

static ty_result solve(figure_run* run, const ty_scene* scene, int variant, ty_pop** out) {
    ty_pop_def def = ty_default_pop_def();
    def.mode = modes[variant];
    def.resolution = run->options->quick ? RESOLUTION / 4 : RESOLUTION;
    def.keep_lobes = true;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    return ty_pop_solve(scene, &def, out, NULL);
}

static void add_series(plot_chart* chart, const char* name, const double (*fluence)[3], plot_style style) {
    plot_series* series = &chart->series[chart->series_count++];
    snprintf(series->name, PLOT_LABEL_SIZE, "%s", name);
    series->style = style;
    for (int i = 0; i < RADII; ++i) plot_add_point(series, (i + 0.5) * line.upper[0] / RADII, fluence[i][1], 0);
}

/* Scattered fluence: in the cube as numbers, along the line as a curve. */
static ty_result compare_fluence(figure_run* run, const ty_scene* scene, int variant, const char* item,
                                 const fluence_truth* in_cube, double (*fluence)[3], plot_chart* chart) {
    ty_pop* light = NULL;
    ty_result result = solve(run, scene, variant, &light);
    if (result == TY_OK) result = pop_fluence(light, &cube, fluence);
    if (result == TY_OK) {
        const figure_errors errors = fluence_compare(&cube, (const double(*)[3])fluence, in_cube);
        const bool ours = modes[variant] == TY_POP_MODE_SPLIT;
        figure_expect(run, item, "mean ratio of fluence", "1", errors.mean_ratio, ours ? 1 : NAN, ours ? 0.1 : NAN);
        if (result == TY_OK) figure_note(run, item, "relative RMSE of fluence", "1", errors.relative_rmse);
    }
    if (result == TY_OK) result = pop_fluence(light, &line, fluence);
    if (result == TY_OK)
        add_series(chart, mode_names[variant], (const double(*)[3])fluence, variant == 0 ? PLOT_LINE : PLOT_DASHES);
    ty_pop_destroy(light);
    return result;
}

static ty_result fill_chart(figure_run* run, const ty_scene* scene, const char* item, plot_chart* chart) {
    static fluence_truth truths[2];
    static double fluence[FLUENCE_CELLS_MAX][3];
    ty_result result = path_fluence(run, scene, &cube, SAMPLES, &truths[0]);
    if (result == TY_OK) result = path_fluence(run, scene, &line, 256 * SAMPLES, &truths[1]);
    if (result == TY_OK) add_series(chart, "path tracing", (const double(*)[3])truths[1].scattered, PLOT_DOTS);
    for (int v = 0; v < VARIANTS && result == TY_OK; ++v) {
        char own[FIGURE_NAME_SIZE];
        snprintf(own, sizeof own, "%s, %s", item, mode_names[v]);
        result = compare_fluence(run, scene, v, own, &truths[0], fluence, chart);
    }
    return result;
}

/* The charts, and the numbers of both rows of pictures. */
static ty_result fill_charts(figure_run* run, const figure_matrix* matrix, plot_chart charts[COSINES]) {
    ty_result result = TY_OK;
    for (int column = 0; column < COSINES && result == TY_OK; ++column) {
        ty_scene* scene = NULL;
        char item[FIGURE_NAME_SIZE];
        charts[column] = (plot_chart){.title = "light that has scattered",
                                      .x_label = "distance to the light, m",
                                      .y_label = "fluence (green), W/m²",
                                      .y_logarithmic = true,
                                      .width = 230,
                                      .height = 220};
        snprintf(item, sizeof item, "%s, split", scenes[column].item);
        figure_expect(run, item, "mean ratio of the picture", "1", matrix->errors[column][1].mean_ratio, 1, 0.1);
        if (result == TY_OK) result = figure_load(run, &scenes[column], &scene);
        if (result == TY_OK) result = fill_chart(run, scene, scenes[column].item, &charts[column]);
        ty_scene_destroy(scene);
    }
    return result;
}

ty_result figure_pop_sphere(figure_run* run) {
    static plot_chart charts[COSINES];
    const bool quick = run->options->quick;
    const figure_variant variants[1 + VARIANTS] = {
        figure_path,
        {.title = "split",
         .method = &ty_method_pop,
         .options = quick ? "mode=split resolution=8" : "mode=split resolution=32"},
        {.title = "published",
         .method = &ty_method_pop,
         .options = quick ? "mode=published resolution=8" : "mode=published resolution=32",
         .level = true}};
    figure_matrix matrix = {
        .scenes = scenes, .scene_count = COSINES, .variants = variants, .variant_count = 1 + VARIANTS};
    ty_result result = figure_show_matrix(run, &matrix, PICTURE_WIDTH);
    if (result == TY_OK) result = fill_charts(run, &matrix, charts);
    if (result == TY_OK) plot_page_charts(&run->page, charts, COSINES);
    figure_free_matrix(&matrix);
    figure_caption(run,
                   "A point light at the center of a sphere of radius 2.5 m, σs = {0.8, 1, 1.3}/m, nothing absorbed, "
                   "on %d³ cells of a radial grid. As published light is far too bright (it counts once for every cell "
                   "that it came through, and is trapped); these pictures are made as bright as path tracing's. Errors "
                   "of pictures are of means over %d × %d pixels; relative RMSEs are without the truth's own noise.",
                   run->options->quick ? RESOLUTION / 4 : RESOLUTION, FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}
