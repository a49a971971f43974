/* The step cloud of the intercomparison of 3D radiation codes (I3RC phase I, case 1; Cahalan et al. 2005): domain means
 * beside the consensus of the participating codes, and quantities by pixels, beside it where its files are. */
#include "figures/figure.h"

#include <math.h>
#include <stdio.h>

enum { PIXELS = 32, EXPERIMENTS = 4, QUANTITIES = 5, SAMPLES = 49152, SAMPLES_QUICK = 256 };

/* In the order of the table. */
static const struct {
    const char* name;
    const char* file; /* in the names of consensus files; NULL: of the slanted view */
    double tolerance; /* relative */
} quantities[QUANTITIES] = {{"reflectance", "R", 0.015},
                            {"transmittance", "T", 0.015},
                            {"absorptance", "A", 0.02},
                            {"nadir reflectivity", "Iu", 0.02},
                            {"reflectivity at 60 degrees", NULL, 0.02}};

/* Means of the consensus files over the 32 pixels; NaN: there is none. */
static const struct {
    double zenith, albedo;
    const char* view; /* of the consensus */
    double azimuth;   /* of the sensor at 60 degrees, our way */
    double expected[QUANTITIES];
} experiments[EXPERIMENTS] = {
    {0, 1, "I602", 180, {0.327595, 0.672398, NAN, 0.256396, 0.404250}},
    {60, 1, "I602", 180, {0.580444, NAN, NAN, 0.406070, 0.566741}},
    {0, 0.99, "I602", 180, {NAN, NAN, NAN, NAN, NAN}},
    {60, 0.99, "I601", 0, {0.476539, 0.324903, 0.198577, 0.322559, 0.886163}},
};

static ty_result estimate(figure_run* run, int index, ty_flux** out) {
    static const double levels[2] = {0, 250};
    char zenith[64], thin[64], thick[64];
    snprintf(zenith, sizeof zenith, "lights[0].zenith=%g", experiments[index].zenith);
    snprintf(thin, sizeof thin, "media[0].albedo=%g", experiments[index].albedo);
    snprintf(thick, sizeof thick, "media[1].albedo=%g", experiments[index].albedo);
    const char* const overrides[] = {zenith, thin, thick};
    const ty_flux_view views[2] = {{0, 0}, {60, experiments[index].azimuth}};
    ty_scene* scene = NULL;
    ty_path_def path = ty_default_path_def();
    ty_flux_def def = ty_default_flux_def();
    path.spp = figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES);
    path.seed = run->session->common.seed;
    path.progress = cli_progress_report;
    path.progress_user = &run->session->progress;
    def.levels = levels;
    def.level_count = 2;
    def.columns[0] = PIXELS;
    def.views = views;
    def.view_count = 2;
    ty_result result = figure_load_scene(run, "builtin:step_cloud", overrides, 3, &scene);
    if (result == TY_OK) result = ty_path_flux(scene, &path, &def, out, NULL);
    ty_scene_destroy(scene);
    return result;
}

/* A quantity of a pixel and its standard error. Reflectivity is pi I / (mu0 F0), where mu0 F0 is 1. */
static double value_of(const ty_flux* flux, int quantity, int pixel, double* error) {
    static const double pi = 3.14159265358979323846;
    static const struct {
        ty_flux_quantity quantity;
        int32_t index;
        double factor;
    } kinds[QUANTITIES] = {{TY_FLUX_UP, 1, 1},
                           {TY_FLUX_DOWN_DIFFUSE, 0, 1},
                           {TY_FLUX_ABSORBED, 0, 1},
                           {TY_FLUX_RADIANCE, 0, pi},
                           {TY_FLUX_RADIANCE, 1, pi}};
    const ty_flux_quantity kind = kinds[quantity].quantity;
    double value = ty_flux_values(flux, kind, kinds[quantity].index)[3 * pixel];
    *error = ty_flux_errors(flux, kind, kinds[quantity].index)[3 * pixel];
    if (kind == TY_FLUX_DOWN_DIFFUSE) {
        value += ty_flux_values(flux, TY_FLUX_DOWN_DIRECT, 0)[3 * pixel];
        *error = hypot(*error, ty_flux_errors(flux, TY_FLUX_DOWN_DIRECT, 0)[3 * pixel]);
    }
    *error *= kinds[quantity].factor;
    return kinds[quantity].factor * value;
}

static void note_means(figure_run* run, int index, const ty_flux* flux, plot_table* table) {
    char item[FIGURE_NAME_SIZE];
    snprintf(item, sizeof item, "experiment %d", index + 1);
    plot_set_cell(table, 1 + index, 0, "%d: sun at %g°, albedo %g", index + 1, experiments[index].zenith,
                  experiments[index].albedo);
    for (int q = 0; q < QUANTITIES; ++q) {
        const double expected = experiments[index].expected[q];
        double mean = 0;
        for (int i = 0; i < PIXELS; ++i) {
            double error;
            mean += value_of(flux, q, i, &error) / PIXELS;
        }
        if (isfinite(expected)) {
            figure_expect(run, item, quantities[q].name, "1", mean, expected, quantities[q].tolerance * expected);
            plot_set_cell(table, 1 + index, 1 + q, "%.4f / %.4f", mean, expected);
        } else {
            figure_note(run, item, quantities[q].name, "1", mean);
            plot_set_cell(table, 1 + index, 1 + q, "%.4f", mean);
        }
    }
}

/* Pixels of the consensus as dots, where its file is in the folder of third-party data. */
static void add_consensus(const figure_run* run, int index, int quantity, plot_series* series) {
    char name[96], path[FIGURE_PATH_SIZE];
    const char* file = quantities[quantity].file != NULL ? quantities[quantity].file : experiments[index].view;
    snprintf(name, sizeof name, "i3rc/I3RC_cons_res_case1_exp%d_%s.txt", index + 1, file);
    if (!figure_has_data(run, name)) return;
    snprintf(path, sizeof path, "%s/%s", run->options->data, name);
    FILE* stream = fopen(path, "r");
    double value;
    for (int i = 0; stream != NULL && i < PIXELS && fscanf(stream, "%lf", &value) == 1; ++i)
        plot_add_point(series, i + 1, value, 0);
    if (stream != NULL) fclose(stream);
}

static void add_lines(const figure_run* run, int index, const ty_flux* flux, plot_chart* chart) {
    static const int shown[] = {0, 2, 3, 4};
    for (size_t k = 0; k < sizeof shown / sizeof shown[0]; ++k) {
        if (shown[k] == 2 && !(experiments[index].albedo < 1)) continue;
        plot_series* line = &chart->series[chart->series_count++];
        snprintf(line->name, PLOT_LABEL_SIZE, "%s", quantities[shown[k]].name);
        line->style = PLOT_LINE;
        line->color = 1 + (int)k;
        for (int i = 0; i < PIXELS; ++i) {
            double error;
            const double value = value_of(flux, shown[k], i, &error);
            plot_add_point(line, i + 1, value, error);
        }
        plot_series* dots = &chart->series[chart->series_count];
        dots->style = PLOT_DOTS;
        dots->color = 1 + (int)k;
        add_consensus(run, index, shown[k], dots);
        if (dots->count > 0) ++chart->series_count;
    }
}

static ty_result run_experiment(figure_run* run, int index, plot_chart* chart, plot_table* table) {
    static const char* const titles[EXPERIMENTS] = {"(1) sun at 0°, albedo 1", "(2) sun at 60°, albedo 1",
                                                    "(3) sun at 0°, albedo 0.99", "(4) sun at 60°, albedo 0.99"};
    ty_flux* flux = NULL;
    *chart = (plot_chart){.title = titles[index], .x_label = "pixel", .y_label = "over the sun's flux"};
    const ty_result result = estimate(run, index, &flux);
    if (result == TY_OK) {
        note_means(run, index, flux, table);
        add_lines(run, index, flux, chart);
    }
    ty_flux_destroy(flux);
    return result;
}

ty_result figure_i3rc_step(figure_run* run) {
    static plot_chart charts[EXPERIMENTS];
    plot_table table = {0};
    ty_result result = plot_create_table(1 + EXPERIMENTS, 1 + QUANTITIES, 1, &table);
    for (int q = 0; q < QUANTITIES && result == TY_OK; ++q) plot_set_cell(&table, 0, 1 + q, "%s", quantities[q].name);
    for (int i = 0; i < EXPERIMENTS && result == TY_OK; ++i) result = run_experiment(run, i, &charts[i], &table);
    if (result == TY_OK) {
        plot_page_charts(&run->page, charts, 2);
        plot_page_charts(&run->page, charts + 2, 2);
        plot_page_table(&run->page, &table);
    }
    plot_free_table(&table);
    figure_caption(
        run, "builtin:step_cloud: 32 pixels across 0.5 km that repeat, 0.25 km thick, optical thickness 2 in the "
             "first 16 and 18 in the others, g 0.85, no ground. Lines: path, with standard errors. Dots: consensus "
             "of the codes of I3RC phase I, where its files are there. Table: means over all pixels, measured / "
             "consensus; there is none of experiment 3. Slanted views are those that the consensus has: backward "
             "of experiments 1 and 2, forward of 4.");
    return result;
}
