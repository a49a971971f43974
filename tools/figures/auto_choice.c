/* The choices of method auto over many scenes, and their loss against the best possible choice. */
#include "scenes/auto.h"
#include "figures/view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    PATH = 0,
    METHODS = 7,
    BUDGETS = 3,
    LONGEST = 96, /* pixels */
    LONGEST_QUICK = 32,
    SAMPLES = 512,
    SAMPLES_QUICK = 8,
    COLUMNS = 7 + BUDGETS
};

static const ty_method* const methods[METHODS] = {&ty_method_path, &ty_method_dom,    &ty_method_pop,    &ty_method_fld,
                                                  &ty_method_lpv,  &ty_method_screen, &ty_method_octaves};
static const double budgets[BUDGETS] = {0.3, 1, 10}; /* s */
/* Methods count as equally fast up to this factor, the uncertainty of times. */
static const double slack = 1.5;
/* Fraction of the reference's noise below which errors are not distinguished. */
static const double noise_fraction = 0.3;

/* Result of a method for a scene; path with the scene's own samples. */
typedef struct auto_result {
    double error; /* relative RMSE of means of blocks, corrected for the reference's noise; NaN: the method refuses the
                     scene */
    double seconds; /* CPU seconds over threads, at the scene's own resolution */
} auto_result;

typedef struct auto_outcome {
    const auto_scene* scene;
    ty_choice choice;
    int chosen, best, best_within[BUDGETS];
    double best_error, loss;
    auto_result results[METHODS];
} auto_outcome;

/* The state of a scene's measurement. */
typedef struct auto_trial {
    figure_run* run;
    ty_scene* scene;
    int32_t size[2], own[2]; /* pixels: of the compared images, and of the timed images */
    double pixels;           /* pixels at the scene's own resolution per timed pixel */
    ty_image* truth;
    double noise, mean;
} auto_trial;

/* ---- measuring ---- */

static void fit(auto_trial* trial) {
    const ty_camera_def camera = ty_scene_camera(trial->scene);
    const bool quick = trial->run->options->quick;
    const int32_t longest = quick ? LONGEST_QUICK : LONGEST;
    const int32_t side = camera.resolution[0] > camera.resolution[1] ? camera.resolution[0] : camera.resolution[1];
    for (int a = 0; a < 2; ++a) {
        const int32_t blocks = (int32_t)lround((double)longest * camera.resolution[a] / side / FIGURE_BLOCK);
        trial->size[a] = FIGURE_BLOCK * (blocks > 1 ? blocks : 1);
        trial->own[a] = quick ? trial->size[a] : camera.resolution[a];
    }
    trial->pixels = (double)camera.resolution[0] * camera.resolution[1] / ((double)trial->own[0] * trial->own[1]);
}

/* Renders; seconds: CPU time over threads. */
static ty_result render(auto_trial* trial, const ty_method* method, cli_request request, const int32_t size[2],
                        ty_image** out, cli_report* report, double* seconds) {
    cli_session* session = trial->run->session;
    *report = (cli_report){.method = method->name};
    request.seed += session->common.seed;
    request.width = size[0];
    request.height = size[1];
    const double begun = cli_cpu_seconds();
    const ty_result result = cli_render_method(session, trial->scene, method, &request, out, report);
    *seconds = (cli_cpu_seconds() - begun) / ty_context_threads(session->context);
    return result == TY_OK ? figure_check_interrupt() : result;
}

/* Renders the reference, whose noise is path's error. */
static ty_result measure_path(auto_trial* trial, auto_result* out) {
    const int32_t samples = figure_samples(trial->run, trial->run->options->quick ? SAMPLES_QUICK : SAMPLES);
    const ty_camera_def camera = ty_scene_camera(trial->scene);
    const int32_t own = ty_scene_render_settings(trial->scene).spp;
    const cli_request request = {.spp = samples, .seed = 1, .aovs = TY_AOV_VARIANCE};
    cli_report report;
    double noise[4], seconds, sum = 0;
    const ty_result result = render(trial, &ty_method_path, request, trial->size, &trial->truth, &report, &seconds);
    if (result != TY_OK) return result;
    const size_t pixels = (size_t)trial->size[0] * (size_t)trial->size[1];
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < pixels; ++i) sum += (double)ty_image_plane_const(trial->truth, c)[i];
    trial->mean = sum / (3 * (double)pixels);
    bench_noise(trial->truth, FIGURE_BLOCK, noise);
    trial->noise = noise[3];
    out->error = trial->noise / trial->mean * sqrt((double)samples / own);
    out->seconds = seconds * camera.resolution[0] * camera.resolution[1] / (double)pixels * own / samples;
    return TY_OK;
}

/* Renders again at the scene's own resolution, but surfaces with one path per pixel, because their time is proportional
 * to samples. */
static ty_result time_method(auto_trial* trial, const ty_method* method, auto_result* out) {
    const cli_request request = {.spp = 1};
    const int32_t samples = ty_scene_render_settings(trial->scene).spp;
    ty_image* image = NULL;
    cli_report report;
    double seconds = 0;
    const ty_result result = render(trial, method, request, trial->own, &image, &report, &seconds);
    const double own = report.run.own_seconds / report.run.path.seconds;
    out->seconds = seconds * trial->pixels * (own + (1 - own) * samples);
    ty_image_destroy(image);
    return result;
}

static ty_result measure_method(auto_trial* trial, const ty_method* method, auto_result* out) {
    ty_context* context = trial->run->session->context;
    const cli_request request = {.spp = ty_scene_render_settings(trial->scene).spp};
    ty_image* image = NULL;
    cli_report report;
    ty_difference difference;
    double seconds;
    out->error = NAN;
    ty_result result = method->check != NULL ? method->check(trial->scene) : TY_OK;
    if (result == TY_OK) result = render(trial, method, request, trial->size, &image, &report, &seconds);
    if (result == TY_ERROR_ARGUMENT) {
        ty_take_error(context);
        return TY_OK;
    }
    if (result == TY_OK) result = time_method(trial, method, out);
    if (result == TY_OK) result = ty_image_compare(context, image, trial->truth, FIGURE_BLOCK, &difference);
    if (result == TY_OK) {
        const double square = difference.rmse[3] * difference.rmse[3] - trial->noise * trial->noise;
        out->error = fmax(sqrt(fmax(square, 0)), noise_fraction * trial->noise) / trial->mean;
    }
    ty_image_destroy(image);
    return result;
}

/* ---- evaluation ---- */

/* The method with the smallest error within a time; path's error scales with 1 / sqrt(samples). */
static int find_best(const auto_result results[METHODS], double seconds, double* error) {
    int best = PATH;
    *error = results[PATH].error * sqrt(results[PATH].seconds / seconds);
    for (int m = PATH + 1; m < METHODS; ++m) {
        if (!(results[m].error < *error) || results[m].seconds > seconds * slack) continue;
        best = m;
        *error = results[m].error;
    }
    return best;
}

static void evaluate(auto_outcome* out) {
    double error;
    for (int m = 0; m < METHODS; ++m)
        if (strcmp(methods[m]->name, out->choice.method) == 0) out->chosen = m;
    const auto_result* chosen = &out->results[out->chosen];
    out->best = find_best(out->results, chosen->seconds, &out->best_error);
    if (!(chosen->error > out->best_error)) out->best = out->chosen;
    out->loss = chosen->error / fmin(out->best_error, chosen->error);
    for (int b = 0; b < BUDGETS; ++b) out->best_within[b] = find_best(out->results, budgets[b], &error);
}

static void note(figure_run* run, const auto_outcome* outcome) {
    const char* name = outcome->scene->name;
    const ty_scene_features* scene_features = &outcome->choice.features;
    const struct {
        const char* name;
        double value;
    } numbers[] = {{"media's part of the frame", scene_features->media},
                   {"optical thickness", scene_features->thickness},
                   {"opacity", scene_features->opacity},
                   {"g", scene_features->g},
                   {"albedo", scene_features->albedo},
                   {"mean free paths in a cell", scene_features->cell},
                   {"surfaces' part of the frame", scene_features->surfaces},
                   {"enclosed", scene_features->enclosed}};
    char item[FIGURE_NAME_SIZE];
    figure_expect(run, name, "loss", "1", outcome->loss, 1, 1);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i)
        figure_note(run, name, numbers[i].name, "1", numbers[i].value);
    for (int m = 0; m < METHODS; ++m) {
        if (isnan(outcome->results[m].error)) continue;
        snprintf(item, sizeof item, "%s, %s%s", name, methods[m]->name, m == outcome->chosen ? " (chosen)" : "");
        figure_notes(run, item, {"relative RMSE", "1", outcome->results[m].error},
                     {"time", "s", outcome->results[m].seconds});
    }
}

static ty_result try_scene(figure_run* run, const auto_scene* from, auto_outcome* out) {
    const ty_choose_def def = ty_default_choose_def();
    auto_trial trial = {.run = run};
    *out = (auto_outcome){.scene = from};
    ty_result result = auto_load_scene(run->session->context, from, run->options->data, &trial.scene);
    if (result == TY_OK) result = ty_choose_method(trial.scene, &def, &out->choice);
    if (result == TY_OK) {
        fit(&trial);
        result = measure_path(&trial, &out->results[PATH]);
    }
    for (int m = PATH + 1; m < METHODS && result == TY_OK; ++m)
        result = measure_method(&trial, methods[m], &out->results[m]);
    if (result == TY_OK) {
        evaluate(out);
        note(run, out);
    }
    ty_image_destroy(trial.truth);
    ty_scene_destroy(trial.scene);
    return result;
}

/* ---- the page ---- */

static void fill_row(plot_table* table, int row, const auto_outcome* outcome) {
    const auto_result* chosen = &outcome->results[outcome->chosen];
    plot_set_cell(table, row, 0, "%s", outcome->scene->name);
    plot_set_cell(table, row, 1, "%s", outcome->choice.method);
    plot_set_cell(table, row, 2, "%.3f", chosen->error);
    plot_set_cell(table, row, 3, "%.2g", chosen->seconds);
    plot_set_cell(table, row, 4, "%s", methods[outcome->best]->name);
    plot_set_cell(table, row, 5, "%.3f", fmin(outcome->best_error, chosen->error));
    plot_set_cell(table, row, 6, "%.2f", outcome->loss);
    for (int b = 0; b < BUDGETS; ++b) plot_set_cell(table, row, 7 + b, "%s", methods[outcome->best_within[b]]->name);
}

/* Geometric mean of the losses, and the number of losses above 1.5. */
static void note_losses(figure_run* run, const char* item, const auto_outcome* const* outcomes, int count) {
    double logarithms = 0;
    int wrong = 0;
    for (int i = 0; i < count; ++i) {
        logarithms += log(outcomes[i]->loss);
        wrong += outcomes[i]->loss > 1.5;
    }
    figure_notes(run, item, {"scenes", "1", count}, {"mean loss, geometric", "1", exp(logarithms / count)},
                 {"scenes whose loss is above 1.5", "1", wrong});
}

static ty_result show(figure_run* run, const char* title, const auto_outcome* outcomes, int all, bool held_out) {
    static const char* const heads[COLUMNS] = {"",          "choice", "error",    "time, s", "best then",
                                               "its error", "loss",   "in 0.3 s", "in 1 s",  "in 10 s"};
    const auto_outcome* shown[AUTO_SCENES_MAX];
    int count = 0;
    plot_table table;
    for (int i = 0; i < all; ++i)
        if (outcomes[i].scene->held_out == held_out) shown[count++] = &outcomes[i];
    if (count == 0) return TY_OK;
    ty_result result = plot_create_table(1 + count, COLUMNS, 1, &table);
    if (result != TY_OK) return result;
    for (int c = 0; c < COLUMNS; ++c) plot_set_cell(&table, 0, c, "%s", c == 0 ? title : heads[c]);
    for (int i = 0; i < count; ++i) fill_row(&table, 1 + i, shown[i]);
    plot_page_table(&run->page, &table);
    plot_free_table(&table);
    note_losses(run, title, shown, count);
    return TY_OK;
}

ty_result figure_auto_choice(figure_run* run) {
    auto_outcome* outcomes = calloc((size_t)auto_scene_count, sizeof *outcomes);
    if (outcomes == NULL) return TY_ERROR_MEMORY;
    int count = 0;
    ty_result result = TY_OK;
    for (int i = 0; i < auto_scene_count && result == TY_OK; ++i) {
        const auto_scene* scene = &auto_scenes[i];
        if (scene->file != NULL && !figure_has_data(run, scene->file)) continue;
        result = try_scene(run, scene, &outcomes[count++]);
    }
    if (result == TY_OK) result = show(run, "scenes that the rules were made with", outcomes, count, false);
    if (result == TY_OK) result = show(run, "scenes held out", outcomes, count, true);
    free(outcomes);
    figure_caption(
        run,
        "Choices of method auto%s, against the method with the smallest error in that time. Errors: relative RMSE "
        "of means over %d × %d pixels of pictures %d pixels wide or high, without the truth's noise. Time: "
        "of processors over threads, at the scene's own size; of path at the scene's samples, its error in "
        "other times by its variance. Loss: the choice's error over that of the best that takes at most %g "
        "times its time. Last: the method with the smallest error in a time.",
        run->options->data == NULL ? " (third-party data are not there)" : "", FIGURE_BLOCK, FIGURE_BLOCK,
        run->options->quick ? LONGEST_QUICK : LONGEST, slack);
    return result;
}
