/* Means of images over seeds, with lamps in media: how far one image may be off, by equiangular sampling alone (path
 * tracing before it had lamp directions) and with lamp directions. */
#include "figures/view.h"

#include <math.h>
#include <stdio.h>

enum { SCENES = 7, BALLS = 4, SEEDS = 16, SEEDS_QUICK = 4, PIXELS = 128, SAMPLES = 128, SAMPLES_QUICK = 16 };

/* Deviations below this are drawn at it, %. */
static const double least_drawn = 0.01;

/* 2 % at 256 x 256: with a quarter of the pixels, twice that. */
static const double tolerance = 0.04;

/* The balls first; place: x in their chart. */
static const struct {
    figure_scene scene;
    double place;
} seed_scenes[SCENES] = {
    {{.title = "ball, g 0.5", .scene = "path_lamp_in_ball", .overrides = {"media[0].g=0.5"}}, 0.5},
    {{.title = "ball, g 0.7", .scene = "path_lamp_in_ball", .overrides = {"media[0].g=0.7"}}, 0.7},
    {{.title = "ball, g 0.9", .scene = "path_lamp_in_ball", .overrides = {"media[0].g=0.9"}}, 0.9},
    {{.title = "ball, g 0.96", .scene = "path_lamp_in_ball", .overrides = {"media[0].g=0.96"}}, 0.96},
    {{.title = "wall", .scene = "path_lamp_at_wall"}, 1},
    {{.title = "two lamps", .scene = "path_two_lamps"}, 2},
    {{.title = "spot", .scene = "builtin:fog_cornell"}, 3}};

/* Means of images: with lamp directions first. */
typedef struct seed_means {
    double mean[2][SEEDS];
    double truth; /* mean over seeds, with lamp directions */
} seed_means;

static int seed_count(const figure_run* run) {
    return run->options->quick ? SEEDS_QUICK : SEEDS;
}

static ty_result render_mean(figure_run* run, const ty_scene* scene, bool point_light_directions, int seed,
                             double* mean) {
    ty_path_def def = ty_default_path_def();
    int32_t size[2];
    ty_image* image = NULL;
    figure_view_size(run, PIXELS, PIXELS, size);
    def.width = size[0];
    def.height = size[1];
    def.spp = figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES);
    def.seed = (uint64_t)seed + 1;
    def.point_light_directions = point_light_directions;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    const ty_result result = ty_path_render(scene, &def, &image, NULL);
    if (result == TY_OK) *mean = figure_mean(image);
    ty_image_destroy(image);
    return result;
}

static ty_result fill_means(figure_run* run, int index, seed_means* out) {
    ty_scene* scene = NULL;
    ty_result result = figure_load(run, &seed_scenes[index].scene, &scene);
    out->truth = 0;
    for (int seed = 0; seed < seed_count(run) && result == TY_OK; ++seed) {
        result = render_mean(run, scene, true, seed, &out->mean[0][seed]);
        if (result == TY_OK) result = render_mean(run, scene, false, seed, &out->mean[1][seed]);
        if (result == TY_OK) out->truth += out->mean[0][seed] / seed_count(run);
    }
    ty_scene_destroy(scene);
    return result;
}

static void show_means(figure_run* run, int index, const seed_means* means, plot_chart* chart) {
    static const char* const names[2] = {"image means off their mean, at most",
                                         "the same by equiangular sampling alone, at most"};
    const double beside = index < BALLS ? 0.008 : 0.06;
    for (int way = 0; way < 2; ++way) {
        double worst = 0;
        for (int seed = 0; seed < seed_count(run); ++seed) {
            const double off = fabs(means->mean[way][seed] / means->truth - 1);
            worst = fmax(worst, off);
            plot_add_point(&chart->series[1 - way], seed_scenes[index].place + (way == 0 ? beside : -beside),
                           fmax(100 * off, least_drawn), 0);
        }
        if (way == 0)
            figure_expect(run, seed_scenes[index].scene.title, names[way], "1", worst, 0, tolerance);
        else
            figure_note(run, seed_scenes[index].scene.title, names[way], "1", worst);
    }
}

/* The tolerance is drawn from first to last. */
static void start_chart(plot_chart* chart, const char* title, const char* x_label, double first, double last) {
    *chart = (plot_chart){.title = title,
                          .x_label = x_label,
                          .y_label = "deviation of an image's mean, %",
                          .y_logarithmic = true,
                          .height = 330,
                          .series_count = 3};
    for (int way = 0; way < 2; ++way) {
        plot_series* series = &chart->series[way];
        snprintf(series->name, PLOT_LABEL_SIZE, "%s", way == 0 ? "before: equiangular" : "with lamp directions");
        series->style = PLOT_DOTS;
        series->color = 1 + way;
    }
    plot_series* bound = &chart->series[2];
    snprintf(bound->name, PLOT_LABEL_SIZE, "tolerance");
    bound->style = PLOT_DASHES;
    bound->color = 3;
    plot_add_point(bound, first, 100 * tolerance, 0);
    plot_add_point(bound, last, 100 * tolerance, 0);
}

ty_result figure_path_seeds(figure_run* run) {
    static plot_chart charts[2];
    start_chart(&charts[0], "(a) a lamp in a ball of fog", "mean cosine g", 0.45, 1);
    start_chart(&charts[1], "(b) a lamp at a wall, two lamps, a spot", "1: at a wall, 2: two lamps, 3: a spot light",
                0.5, 3.5);
    ty_result result = TY_OK;
    for (int i = 0; i < SCENES && result == TY_OK; ++i) {
        seed_means means;
        result = fill_means(run, i, &means);
        if (result == TY_OK) show_means(run, i, &means, &charts[i < BALLS ? 0 : 1]);
    }
    if (result == TY_OK) plot_page_charts(&run->page, charts, 2);
    figure_caption(run,
                   "Each dot is one image: %d seeds, %d samples per pixel. Its mean against the mean of all seeds with "
                   "lamp directions; deviations below %g %% are drawn there. Left of each pair: equiangular sampling "
                   "alone, as before lamp directions, without the outliers of coarse random numbers in narrow lobes, "
                   "which are mended in both. (a) A point light in the center of a ball of optical radius 2.5, albedo "
                   "1. (b) The same at g 0.7 with a wall 0.1 m behind the lamp and with two lamps; "
                   "builtin:fog_cornell, a spot light in a box of fog.",
                   seed_count(run), figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES), least_drawn);
    return result;
}
