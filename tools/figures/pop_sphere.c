/* Fig. 10 of the paper: a point light at the center of a sphere, on radial grids. */
#include "figures/pop_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

static const double cosines[COSINES] = {0, 0.5, 0.9};
static const ty_pop_mode modes[VARIANTS] = {TY_POP_MODE_SPLIT, TY_POP_MODE_PUBLISHED};
static const char* const mode_names[VARIANTS] = {"split", "published"};
static const char* const row_titles[1 + VARIANTS] = {"path tracing", "split", "published"};

/* A cube inside the sphere, and a radial line of cells, 0.1 m wide. */
static const pop_box cube = {{-1.4, -1.4, -1.4}, {1.4, 1.4, 1.4}, {EDGE, EDGE, EDGE}};
static const pop_box line = {{0, -0.05, -0.05}, {2.5, 0.05, 0.05}, {RADII, 1, 1}};

static ty_result load(figure_run* run, double g, ty_scene** out) {
    char override[32];
    const char* const overrides[1] = {override};
    snprintf(override, sizeof override, "media[0].g=%g", g);
    return figure_load_scene(run, "pop_sphere", overrides, 1, out);
}

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
                                 const pop_truth* in_cube, double (*fluence)[3], plot_chart* chart) {
    ty_pop* light = NULL;
    ty_result result = solve(run, scene, variant, &light);
    if (result == TY_OK) result = pop_scattered_fluence(light, &cube, fluence);
    if (result == TY_OK) {
        const figure_errors errors = pop_compare_fluence(&cube, (const double(*)[3])fluence, in_cube);
        const bool ours = modes[variant] == TY_POP_MODE_SPLIT;
        result =
            figure_expect(run, item, "mean ratio of fluence", "1", errors.mean_ratio, ours ? 1 : NAN, ours ? 0.1 : NAN);
        if (result == TY_OK) result = figure_note(run, item, "relative RMSE of fluence", "1", errors.relative_rmse);
    }
    if (result == TY_OK) result = pop_scattered_fluence(light, &line, fluence);
    if (result == TY_OK)
        add_series(chart, mode_names[variant], (const double(*)[3])fluence, variant == 0 ? PLOT_LINE : PLOT_DASHES);
    ty_pop_destroy(light);
    return result;
}

static ty_result fill_chart(figure_run* run, const ty_scene* scene, const char* item, plot_chart* chart) {
    pop_truth* truths = calloc(2, sizeof *truths);
    double(*fluence)[3] = calloc(POP_CELLS_MAX, sizeof *fluence);
    ty_result result = truths != NULL && fluence != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) result = pop_path_fluence(run, scene, &cube, SAMPLES, &truths[0]);
    if (result == TY_OK) result = pop_path_fluence(run, scene, &line, 256 * SAMPLES, &truths[1]);
    if (result == TY_OK) add_series(chart, "path tracing", (const double(*)[3])truths[1].scattered, PLOT_DOTS);
    for (int v = 0; v < VARIANTS && result == TY_OK; ++v) {
        char own[FIGURE_NAME_SIZE];
        snprintf(own, sizeof own, "%s, %s", item, mode_names[v]);
        result = compare_fluence(run, scene, v, own, &truths[0], fluence, chart);
    }
    free(fluence);
    free(truths);
    return result;
}

static ty_result fill_column(figure_run* run, int column, plot_sheet* sheet, plot_chart* chart) {
    int32_t size[2];
    ty_scene* scene = NULL;
    figure_picture pictures[1 + VARIANTS] = {0};
    char item[16];
    figure_view_size(run, WIDTH, WIDTH, size);
    snprintf(item, sizeof item, "g %g", cosines[column]);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "g = %g", cosines[column]);
    ty_result result = load(run, cosines[column], &scene);
    ty_pop_def settings = result == TY_OK ? pop_scene_def(scene) : ty_default_pop_def();
    settings.resolution = run->options->quick ? RESOLUTION / 4 : RESOLUTION;
    for (int row = 0; row <= VARIANTS && result == TY_OK; ++row) {
        char own[FIGURE_NAME_SIZE];
        figure_errors errors;
        snprintf(own, sizeof own, "%s, %s", item, row_titles[row]);
        if (row > 0) settings.mode = modes[row - 1];
        result = pop_render(run, own, scene, row > 0 ? &settings : NULL, size, &pictures[row], NULL);
        if (result == TY_OK)
            result = figure_show(run, own, scene, &pictures[row], row > 0 ? &pictures[0] : NULL, row == 2,
                                 plot_sheet_cell(sheet, row, column), &errors);
        if (result == TY_OK && row == 1)
            result = figure_expect(run, own, "mean ratio of the picture", "1", errors.mean_ratio, 1, 0.1);
    }
    if (result == TY_OK) result = fill_chart(run, scene, item, chart);
    for (int row = 0; row <= VARIANTS; ++row) figure_free_picture(&pictures[row]);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_pop_sphere(figure_run* run) {
    plot_sheet sheet = {0};
    plot_chart* charts = calloc(COSINES, sizeof *charts);
    ty_result result =
        charts != NULL ? plot_create_sheet(1 + VARIANTS, COSINES, PICTURE_WIDTH, &sheet) : TY_ERROR_MEMORY;
    for (int column = 0; column < COSINES && result == TY_OK; ++column) {
        charts[column] = (plot_chart){.title = "light that has scattered",
                                      .x_label = "distance to the light, m",
                                      .y_label = "fluence (green), W/m²",
                                      .y_logarithmic = true,
                                      .width = 230,
                                      .height = 220};
        result = fill_column(run, column, &sheet, &charts[column]);
    }
    if (result == TY_OK) {
        for (int row = 0; row <= VARIANTS; ++row)
            snprintf(sheet.row_titles[row], PLOT_LABEL_SIZE, "%s", row_titles[row]);
        plot_page_sheet(&run->page, &sheet);
        plot_page_charts(&run->page, charts, COSINES);
    }
    plot_free_sheet(&sheet);
    free(charts);
    figure_caption(run,
                   "A point light in the middle of a sphere of radius 2.5 m, σs = {0.8, 1, 1.3}/m, nothing absorbed, "
                   "on %d³ cells of a radial grid. As published light is far too bright (it counts once for every cell "
                   "that it came through, and is trapped); these pictures are made as bright as path tracing's. Errors "
                   "of pictures are of means over %d × %d pixels; relative RMSEs are without the truth's own noise.",
                   run->options->quick ? RESOLUTION / 4 : RESOLUTION, FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}
