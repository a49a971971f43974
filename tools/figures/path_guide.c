/* Paths with and without the guide of dom in the same processor time, beside Blender Cycles where its images are there:
 * noise from pairs of independent images, cost of noise = relRMSE^2 x processor seconds, the solve included. */
#include "figures/view.h"

#include <math.h>
#include <stdio.h>

enum { SAMPLES = 64, SAMPLES_QUICK = 8, PICTURE_WIDTH = 300, RENDERERS = 3, PATH_SIZE = FIGURE_PATH_SIZE + 256 };
enum { NONE = 0, DOM = 1, CYCLES = 2 };

static const char* const renderer_names[RENDERERS] = {"path", "path, guide: dom", "Blender Cycles"};

/* The hard scenes first, then those of docs/method/path.md, "How fast it is"; items name the images of Cycles. */
static const figure_scene scenes[] = {
    {.title = "fog Cornell", .item = "fog_cornell", .scene = "builtin:fog_cornell", .width = 192, .height = 192},
    {.title = "sun through a window", .item = "path_window", .scene = "path_window", .width = 192, .height = 144},
    {.title = "Sponza in fog",
     .item = "sponza",
     .file = SPONZA_FILE,
     .scene = "auto_sponza_sky",
     .width = 192,
     .height = 108},
    {.title = "cloud from behind, g 0.9",
     .item = "path_cloud_behind",
     .scene = "path_cloud_behind",
     .width = 192,
     .height = 144,
     .quick = "media[0].density.noise.resolution=24"},
    {.title = "snow under a sky",
     .item = "path_snow",
     .scene = "path_snow",
     .width = 96,
     .height = 72,
     .quick = "media[0].sigma_t=20"},
    {.title = "lamp in a ball, g 0.7",
     .item = "path_lamp_in_ball",
     .scene = "path_lamp_in_ball",
     .width = 192,
     .height = 192},
    {.title = "hall of glowing meshes", .item = "path_hall", .scene = "path_hall", .width = 192, .height = 144},
    {.title = "1000 emitters", .item = "path_emitters", .scene = "path_emitters", .width = 192, .height = 144},
    {.title = "staircase in haze",
     .item = "staircase",
     .file = STAIRCASE_FILE,
     .scene = "auto_staircase",
     .width = 108,
     .height = 192},
    {.title = "lamp behind a corner", .item = "path_corner", .scene = "path_corner", .width = 192, .height = 144},
    {.title = "cube, g 0", .item = "cube_g0", .scene = "builtin:cube_g0", .width = 192, .height = 144},
    {.title = "cube, g 0.7", .item = "cube_g0.7", .scene = "builtin:cube_g0.7", .width = 192, .height = 144},
    {.title = "cube, g 0.96", .item = "cube_g0.96", .scene = "builtin:cube_g0.96", .width = 192, .height = 144},
    {.title = "Cornell box in fog", .item = "cornell_fog", .scene = "builtin:cornell_fog", .width = 192, .height = 192},
    {.title = "cloud in the sun",
     .item = "cloud_sun",
     .scene = "builtin:cloud_sun",
     .width = 192,
     .height = 192,
     .quick = "media[0].density.noise.resolution=24"},
    {.title = "cloud under a sky",
     .item = "cloud_sky",
     .scene = "builtin:cloud_sky",
     .width = 192,
     .height = 192,
     .quick = "media[0].density.noise.resolution=24"},
};
enum { SCENES = sizeof scenes / sizeof scenes[0], HARD = 10, QUICK_STRIDE = 9 };

/* Two images of different seeds. */
typedef struct guide_pair {
    ty_image* images[2];
    double seconds; /* processor time of one, s */
    double noise;   /* relRMSE of one */
    int32_t samples;
} guide_pair;

static void free_pair(guide_pair* pair) {
    ty_image_destroy(pair->images[0]);
    ty_image_destroy(pair->images[1]);
}

static double cost_of(const guide_pair* pair) {
    return pair->noise * pair->noise * pair->seconds;
}

static ty_result render(figure_run* run, const ty_scene* scene, const int32_t size[2], int renderer, int32_t samples,
                        uint64_t seed, ty_image** out, double* seconds) {
    ty_path_def def = ty_default_path_def();
    ty_path_stats stats = ty_default_path_stats();
    ty_result result = ty_method_options(scene, "path", &def);
    def.spp = samples;
    def.seed = run->session->common.seed + seed;
    def.width = size[0];
    def.height = size[1];
    def.guide = renderer == DOM ? TY_PATH_GUIDE_DOM : TY_PATH_GUIDE_NONE;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    if (result == TY_OK) result = ty_path_render(scene, &def, out, &stats);
    *seconds = stats.cpu_seconds;
    return result;
}

/* relRMSE = sqrt(mean (a - b)^2 / 2) / mean of both. */
static ty_result find_noise(figure_run* run, guide_pair* pair) {
    ty_difference difference;
    const ty_result result = ty_image_compare(run->session->context, pair->images[0], pair->images[1], 1, &difference);
    if (result == TY_OK)
        pair->noise =
            sqrt(0.5) * difference.rmse[3] / (0.5 * (figure_mean(pair->images[0]) + figure_mean(pair->images[1])));
    return result;
}

static ty_result render_pair(figure_run* run, const ty_scene* scene, const int32_t size[2], int renderer,
                             int32_t samples, guide_pair* out) {
    double seconds[2] = {0, 0};
    ty_result result = TY_OK;
    out->samples = samples;
    for (uint64_t i = 0; i < 2 && result == TY_OK; ++i)
        result = render(run, scene, size, renderer, samples, i, &out->images[i], &seconds[i]);
    out->seconds = 0.5 * (seconds[0] + seconds[1]);
    return result == TY_OK ? find_noise(run, out) : result;
}

/* The number of guided samples that take so many seconds with their solve: time is linear in samples. */
static ty_result find_samples(figure_run* run, const ty_scene* scene, const int32_t size[2], int32_t samples,
                              double seconds, int32_t* out) {
    const int32_t few = samples / 8 > 1 ? samples / 8 : 1, more = 3 * few;
    double times[2] = {0, 0};
    ty_result result = TY_OK;
    for (int i = 0; i < 2 && result == TY_OK; ++i) {
        ty_image* image = NULL;
        result = render(run, scene, size, DOM, i == 0 ? few : more, 2 + (uint64_t)i, &image, &times[i]);
        ty_image_destroy(image);
    }
    const double each = fmax((times[1] - times[0]) / (more - few), 1e-6), solve = times[0] - few * each;
    *out = (int32_t)fmin(fmax(floor((seconds - solve) / each), 1), 4 * samples);
    return result;
}

static bool stop_at_once(void* user, const ty_progress* progress) {
    (void)user;
    (void)progress;
    return false;
}

/* Records whether the pilot of a long render chooses the guide. */
static ty_result note_choice(figure_run* run, const ty_scene* scene, const int32_t size[2], const char* item) {
    ty_path_def def = ty_default_path_def();
    ty_path_stats stats = ty_default_path_stats();
    ty_image* image = NULL;
    def.spp = 1 << 16;
    def.width = size[0];
    def.height = size[1];
    def.progress = stop_at_once;
    const ty_result result = ty_path_render(scene, &def, &image, &stats);
    ty_image_destroy(image);
    figure_note(run, item, "guide of long renders by default: 0 none, 1 dom", "1", stats.guide == TY_PATH_GUIDE_DOM);
    return result == TY_CANCELLED ? TY_OK : result;
}

/* Images of Cycles by scripts/cycles/noise.py: cycles/NAME.1.exr, .2.exr, and NAME.txt with the processor seconds of
 * one and its samples per pixel. Without them, or of another size, there are none. */
static ty_result read_cycles(figure_run* run, const char* name, const int32_t size[2], guide_pair* out) {
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/cycles/%s.txt", run->options->folder, name);
    FILE* file = fopen(path, "r");
    if (file == NULL) return TY_OK;
    const bool known = fscanf(file, "%lf %d", &out->seconds, &out->samples) == 2;
    fclose(file);
    ty_result result = TY_OK;
    for (int i = 0; i < 2 && known && result == TY_OK; ++i) {
        snprintf(path, sizeof path, "%s/cycles/%s.%d.exr", run->options->folder, name, i + 1);
        result = ty_image_read(run->session->context, path, &out->images[i]);
    }
    if (result != TY_OK || !known) return result;
    if (ty_image_width(out->images[0]) == size[0] && ty_image_height(out->images[0]) == size[1])
        return find_noise(run, out);
    free_pair(out);
    *out = (guide_pair){0};
    return TY_OK;
}

/* Both means must agree within four standard errors, which pixels with independent noise have. */
static void expect_mean(figure_run* run, const char* item, const guide_pair pairs[RENDERERS]) {
    double mean[2], variance[2];
    for (int r = NONE; r <= DOM; ++r) {
        const ty_image* image = pairs[r].images[0];
        mean[r] = 0.5 * (figure_mean(image) + figure_mean(pairs[r].images[1]));
        const double pixels = (double)ty_image_width(image) * (double)ty_image_height(image);
        variance[r] = pairs[r].noise * pairs[r].noise * mean[r] * mean[r] / (2 * pixels);
    }
    figure_expect(run, item, "mean with the guide over that without", "1", mean[DOM] / mean[NONE], 1,
                  4 * sqrt(variance[DOM] + variance[NONE]) / mean[NONE]);
}

static ty_result show_pair(figure_run* run, const ty_scene* scene, const char* item, const guide_pair pairs[RENDERERS],
                           int renderer, plot_cell* cell) {
    const guide_pair* pair = &pairs[renderer];
    char own[FIGURE_NAME_SIZE];
    if (pair->images[0] == NULL) {
        snprintf(cell->lines[0], PLOT_LABEL_SIZE, "not rendered");
        return TY_OK;
    }
    snprintf(own, sizeof own, "%s, %s", item, renderer_names[renderer]);
    figure_notes(run, own, {"processor time", "s", pair->seconds}, {"samples per pixel", "1", pair->samples},
                 {"relative RMSE of noise", "1", pair->noise}, {"cost of noise", "s", cost_of(pair)},
                 {"cost over that of path", "1", cost_of(pair) / cost_of(&pairs[NONE])});
    if (renderer == CYCLES)
        figure_note(run, own, "mean over that of path", "1",
                    figure_mean(pair->images[0]) / figure_mean(pairs[NONE].images[0]));
    snprintf(cell->lines[0], PLOT_LABEL_SIZE, "%.2g s, %d spp, noise %.3f", pair->seconds, pair->samples, pair->noise);
    snprintf(cell->lines[1], PLOT_LABEL_SIZE, "cost %.3g", cost_of(pair));
    return plot_picture_of_image(run->session->context, pair->images[0], ty_scene_camera(scene).exposure,
                                 &cell->picture);
}

static ty_result show_scene(figure_run* run, const figure_scene* from, int row, plot_sheet* sheet, double gains[2]) {
    guide_pair pairs[RENDERERS] = {{.noise = NAN}, {.noise = NAN}, {.noise = NAN}};
    const int32_t samples = figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES);
    int32_t size[2], guided = 1;
    ty_scene* scene = NULL;
    snprintf(sheet->row_titles[row], PLOT_LABEL_SIZE, "%s", from->title);
    figure_view_size(run, from->width, from->height, size);
    ty_result result = figure_load(run, from, &scene);
    if (result == TY_OK) result = render_pair(run, scene, size, NONE, samples, &pairs[NONE]);
    if (result == TY_OK) result = find_samples(run, scene, size, samples, pairs[NONE].seconds, &guided);
    if (result == TY_OK) result = render_pair(run, scene, size, DOM, guided, &pairs[DOM]);
    if (result == TY_OK) result = read_cycles(run, from->item, size, &pairs[CYCLES]);
    if (result == TY_OK) result = note_choice(run, scene, size, from->item);
    if (result == TY_OK) expect_mean(run, from->item, pairs);
    for (int r = 0; r < RENDERERS && result == TY_OK; ++r)
        result = show_pair(run, scene, from->item, pairs, r, plot_sheet_cell(sheet, row, r));
    gains[0] = cost_of(&pairs[DOM]) / cost_of(&pairs[NONE]);
    gains[1] = cost_of(&pairs[CYCLES]) / cost_of(&pairs[NONE]);
    for (int r = 0; r < RENDERERS; ++r) free_pair(&pairs[r]);
    ty_scene_destroy(scene);
    return result;
}

/* Geometric means over the scenes of a set that have the number. */
static void note_means(figure_run* run, const char* item, const double (*gains)[2], int count) {
    static const char* const names[2] = {"cost with the guide over that without, geometric mean",
                                         "cost of Cycles over that of path, geometric mean"};
    for (int g = 0; g < 2; ++g) {
        double sum = 0;
        int known = 0;
        for (int i = 0; i < count; ++i) {
            if (!(gains[i][g] > 0)) continue;
            sum += log(gains[i][g]);
            ++known;
        }
        if (known > 0) figure_note(run, item, names[g], "1", exp(sum / known));
    }
}

ty_result figure_path_guide(figure_run* run) {
    int chosen[SCENES], count = 0;
    double gains[SCENES][2], hard[SCENES][2];
    int hard_count = 0;
    plot_sheet sheet;
    for (int i = 0; i < SCENES; i += run->options->quick ? QUICK_STRIDE : 1)
        if (scenes[i].file == NULL || figure_has_data(run, scenes[i].file)) chosen[count++] = i;
    ty_result result = plot_create_sheet(count, RENDERERS, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    for (int r = 0; r < RENDERERS; ++r) snprintf(sheet.column_titles[r], PLOT_LABEL_SIZE, "%s", renderer_names[r]);
    for (int row = 0; row < count && result == TY_OK; ++row) {
        result = show_scene(run, &scenes[chosen[row]], row, &sheet, gains[row]);
        if (result != TY_OK || chosen[row] >= HARD) continue;
        hard[hard_count][0] = gains[row][0];
        hard[hard_count++][1] = gains[row][1];
    }
    figure_place_sheet(run, result, &sheet, NULL);
    if (result != TY_OK) return result;
    note_means(run, "hard scenes", (const double(*)[2])hard, hard_count);
    note_means(run, "other scenes", (const double(*)[2])(gains + hard_count), count - hard_count);
    figure_caption(
        run,
        "Path tracing at %d samples per pixel, and in the same processor time led by a coarse solve by "
        "discrete ordinates, which counts; images of Blender Cycles by scripts/cycles/noise.py where they "
        "are in the folder cycles. Noise is the relative RMSE of one image, from a pair of seeds; cost is its "
        "square times processor seconds.",
        figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES));
    return result;
}
