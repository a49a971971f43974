/* The unit cube in a beam: fluence by discrete ordinates against path tracing, cell by cell and along an axis. */
#include "figures/pop_cube.h"

#include <math.h>

enum { COSINES = 4, SETTINGS = 5, SAMPLES = 4096 };

static const double cosines[COSINES] = {0, 0.5, 0.7, 0.96};

/* checked: with tolerances. */
static const struct {
    int32_t directions, resolution;
    bool checked, shown;
} settings[SETTINGS] = {
    {48, 32, false, true}, {96, 16, true, false}, {96, 32, true, true}, {96, 64, true, false}, {400, 32, false, true}};

static void format_setting(int setting, char out[PLOT_LABEL_SIZE]) {
    snprintf(out, PLOT_LABEL_SIZE, "%d directions, %d³", (int)settings[setting].directions,
             (int)settings[setting].resolution);
}

static ty_result note_errors(figure_run* run, int column, int setting, const figure_errors* errors,
                             const ty_dom_stats* stats) {
    char item[FIGURE_NAME_SIZE];
    const bool checked = settings[setting].checked && !run->options->quick, forward = cosines[column] > 0.9;
    snprintf(item, sizeof item, "g %g, %d directions, %d^3", cosines[column], (int)settings[setting].directions,
             (int)settings[setting].resolution);
    ty_result result = TY_OK;
    figure_notes(run, item, {"time", "s", stats->seconds}, {"sweeps", "1", stats->sweeps[0]},
                 {"bands", "1", stats->bands});
    figure_expect(run, item, "converged", "1", stats->converged ? 1 : 0, 1, 0);
    figure_expect(run, item, "mean ratio", "1", errors->mean_ratio, checked ? 1 : NAN,
                  checked ? (forward ? 0.03 : 0.015) : NAN);
    if (result != TY_OK) return result;
    figure_expect(run, item, "relative RMSE", "1", errors->relative_rmse, checked ? 0 : NAN,
                  checked ? (forward ? 0.06 : 0.03) : NAN);
    return TY_OK;
}

/* The index of one of the eight mirror images of a cell, which have equal fluence by symmetry. */
static size_t mirrored(const fluence_box* box, int32_t x, int32_t y, int32_t z, int image) {
    const int32_t edge = box->size[0];
    const int32_t u = (image & 1) != 0 ? edge - 1 - x : x, v = (image & 2) != 0 ? edge - 1 - y : y;
    const bool swapped = (image & 4) != 0;
    return ((size_t)z * (size_t)edge + (size_t)(swapped ? u : v)) * (size_t)edge + (size_t)(swapped ? v : u);
}

/* Averages the mirror images. variances: of means over as many independent cells. */
static void average_symmetric(const fluence_box* box, double (*values)[3], bool variances) {
    const int32_t edge = box->size[0];
    for (int32_t z = 0; z < edge; ++z)
        for (int32_t y = 0; y < edge / 2; ++y)
            for (int32_t x = 0; x <= y; ++x)
                for (int c = 0; c < 3; ++c) {
                    const int images = x == y ? 4 : 8;
                    double sum = 0;
                    for (int i = 0; i < images; ++i) sum += values[mirrored(box, x, y, z, i)][c];
                    const double mean = sum / (variances ? images * images : images);
                    for (int i = 0; i < images; ++i) values[mirrored(box, x, y, z, i)][c] = mean;
                }
}

static ty_result find_truth(figure_run* run, const ty_scene* scene, fluence_truth* out) {
    const ty_result result = path_fluence(run, scene, &pop_cube_cells, SAMPLES, out);
    if (result != TY_OK) return result;
    average_symmetric(&pop_cube_cells, out->scattered, false);
    average_symmetric(&pop_cube_cells, out->uncollided, false);
    average_symmetric(&pop_cube_cells, out->variance, true);
    return TY_OK;
}

/* Means over four columns of cells about the axis that the beam comes down. */
static void add_profile(const fluence_box* box, const double (*fluence)[3], const double (*variance)[3],
                        plot_series* series) {
    const int32_t *n = box->size, center[2] = {n[0] / 2, n[1] / 2};
    for (int32_t z = 0; z < n[2]; ++z) {
        double sum = 0, squares = 0;
        for (int32_t y = center[1] - 1; y <= center[1]; ++y)
            for (int32_t x = center[0] - 1; x <= center[0]; ++x) {
                const size_t at = ((size_t)z * (size_t)n[1] + (size_t)y) * (size_t)n[0] + (size_t)x;
                sum += fluence[at][1] / 4;
                if (variance != NULL) squares += variance[at][1] / 4; /* the four are mirror images */
            }
        plot_add_point(series, box->lower[2] + (z + 0.5) * (box->upper[2] - box->lower[2]) / n[2], sum, sqrt(squares));
    }
}

static ty_result run_setting(figure_run* run, const ty_scene* scene, int column, int setting,
                             const fluence_truth* truth, double (*fluence)[3], plot_chart* chart, plot_table* table) {
    char error[16];
    ty_dom_stats stats = ty_default_dom_stats();
    const int32_t resolution = settings[setting].resolution / (run->options->quick ? 4 : 1);
    const ty_result result =
        dom_fluence(run, scene, settings[setting].directions, 0, resolution, &pop_cube_cells, truth, fluence, &stats);
    if (result != TY_OK) return result;
    const figure_errors errors = fluence_compare(&pop_cube_cells, (const double(*)[3])fluence, truth);
    figure_format_error(errors.relative_rmse, error);
    plot_set_cell(table, 2 + setting, 1 + 3 * column, "%.3f", errors.mean_ratio);
    plot_set_cell(table, 2 + setting, 2 + 3 * column, "%s", error);
    plot_set_cell(table, 2 + setting, 3 + 3 * column, "%.0f ms", 1e3 * stats.seconds);
    if (settings[setting].shown) {
        plot_series* series = &chart->series[chart->series_count++];
        format_setting(setting, series->name);
        series->style = PLOT_LINE;
        add_profile(&pop_cube_cells, (const double(*)[3])fluence, NULL, series);
    }
    return note_errors(run, column, setting, &errors, &stats);
}

static ty_result run_column(figure_run* run, int column, fluence_truth* truth, double (*fluence)[3], plot_chart* chart,
                            plot_table* table) {
    static const char* const titles[COSINES] = {"g = 0", "g = 0.5", "g = 0.7", "g = 0.96"};
    ty_scene* scene = NULL;
    *chart = (plot_chart){.title = titles[column],
                          .x_label = "height along the axis, m (the beam comes from above)",
                          .y_label = "scattered fluence, W/m²",
                          .series_count = 1};
    snprintf(chart->series[0].name, PLOT_LABEL_SIZE, "path tracing");
    chart->series[0].style = PLOT_DOTS;
    ty_result result = pop_load_cube(run, cosines[column], &scene);
    if (result == TY_OK) result = find_truth(run, scene, truth);
    if (result == TY_OK)
        add_profile(&pop_cube_cells, (const double(*)[3])truth->scattered, (const double(*)[3])truth->variance,
                    &chart->series[0]);
    for (int setting = 0; setting < SETTINGS && result == TY_OK; ++setting)
        result = run_setting(run, scene, column, setting, truth, fluence, chart, table);
    ty_scene_destroy(scene);
    return result;
}

static void begin_table(plot_table* table) {
    for (int column = 0; column < COSINES; ++column) {
        plot_set_cell(table, 0, 1 + 3 * column, "g = %g", cosines[column]);
        plot_set_cell(table, 1, 1 + 3 * column, "mean ratio");
        plot_set_cell(table, 1, 2 + 3 * column, "rel. RMSE");
        plot_set_cell(table, 1, 3 + 3 * column, "time");
    }
    for (int setting = 0; setting < SETTINGS; ++setting) {
        char name[PLOT_LABEL_SIZE];
        format_setting(setting, name);
        plot_set_cell(table, 2 + setting, 0, "%s", name);
    }
}

ty_result figure_dom_cube(figure_run* run) {
    plot_table table = {0};
    static fluence_truth truth;
    static double fluence[FLUENCE_CELLS_MAX][3];
    static plot_chart charts[COSINES];
    ty_result result = plot_create_table(2 + SETTINGS, 1 + 3 * COSINES, 2, &table);
    if (result == TY_OK) begin_table(&table);
    for (int column = 0; column < COSINES && result == TY_OK; ++column)
        result = run_column(run, column, &truth, fluence, &charts[column], &table);
    if (result == TY_OK) {
        plot_page_charts(&run->page, charts, 2);
        plot_page_charts(&run->page, charts + 2, 2);
        plot_page_table(&run->page, &table);
    }
    plot_free_table(&table);
    figure_caption(
        run,
        "A cube of 1 m, σs = 4/m, nothing absorbed, light from above. Fluence of light that has scattered at least "
        "once, means over 16³ cells; the relative RMSE is that of all cells, without the truth's own noise; eight "
        "mirror images of the truth's cells are taken for one. Directions, and the cells that they go through.");
    return result;
}
