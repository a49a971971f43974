/* Fits the model of method auto to the matrix, and tells what its choices cost on scenes that were left out. */
#include "figures/auto_model.h"
#include "figures/view.h"
#include "cli/text/text_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIZES = 3, LISTED = 1 };

static const ty_picture_size sizes[SIZES] = {{48.0 * 36, 32}, {AUTO_LARGE_PIXELS, 32}, {640.0 * 480, 64}};
static const char* const size_names[SIZES] = {"48 x 36, 32 samples", "160 x 120, 32 samples", "640 x 480, 64 samples"};

typedef struct study {
    auto_row rows[AUTO_ROWS_MAX];
    int32_t count;
    ty_method_model methods[AUTO_METHODS];
    auto_judged held_out[AUTO_ROWS_MAX][SIZES], untried[AUTO_ROWS_MAX][SIZES], fitted[AUTO_ROWS_MAX][SIZES];
} study;

/* ---- measurements ---- */

static bool take_method(const matrix_row* row, int32_t method, const ty_scene_features* features, auto_measured* out) {
    const double pixels = (double)MATRIX_WIDTH * MATRIX_HEIGHT, paths = pixels * MATRIX_SAMPLES;
    const double view_min = 1e-9; /* s, of a view of a pixel that is too short to be measured */
    matrix_cell cell;
    *out = (auto_measured){.rendered = false};
    if (!matrix_find_measured(row->name, auto_methods[method], &cell)) return false;
    if (cell.state != MATRIX_RENDERED) return true;
    out->rendered = true;
    if (method == 0) {
        /* The reference has many more paths than the picture. */
        out->error = row->noise * MATRIX_BLOCK * sqrt(row->reference.samples);
        out->view = fmax(cell.seconds / paths, view_min);
        /* Its error by the reference's noise, which is less noisy itself than a difference of two noisy pictures. */
        if (matrix_find_fine(row->name, auto_methods[method], &out->large))
            out->large.error = out->error / (FIGURE_BLOCK * sqrt(MATRIX_SAMPLES));
        return true;
    }
    out->noise = cell.deviation * features->unscattered;
    const double of_blocks = out->noise / (MATRIX_BLOCK * sqrt(MATRIX_SAMPLES));
    out->error = fmax(sqrt(fmax(cell.rmse * cell.rmse - of_blocks * of_blocks, 0)), 0.3 * ty_error_unseen);
    out->view = fmax(cell.view / pixels, view_min);
    out->surface = cell.surface / paths;
    if (matrix_find_fine(row->name, auto_methods[method], &out->large)) {
        const double noise = out->noise / (FIGURE_BLOCK * sqrt(MATRIX_SAMPLES)), large = out->large.error;
        out->fine =
            sqrt(fmax(large * large - out->error * out->error - noise * noise, ty_error_unseen * ty_error_unseen));
    }
    out->solve = fmax(cell.seconds - cell.view - cell.surface, 1e-3);
    return true;
}

/* Features with trials and without. */
static ty_result take_features(figure_run* run, const char* path, auto_row* out) {
    ty_choose_def def = ty_default_choose_def();
    ty_scene* scene = NULL;
    ty_choice choice;
    ty_result result = ty_scene_load(run->session->context, path, NULL, 0, &scene);
    if (result == TY_OK) result = ty_choose_method(scene, &def, &choice);
    if (result == TY_OK) out->features = choice.features;
    def.trials = false;
    if (result == TY_OK) result = ty_choose_method(scene, &def, &choice);
    if (result == TY_OK) out->untried = choice.features;
    ty_scene_destroy(scene);
    return result;
}

static ty_result take_row(figure_run* run, const char* folder, matrix_row* row, auto_row* out) {
    char path[MATRIX_PATH_SIZE];
    matrix_scene_path(folder, row, path);
    *out = (auto_row){.name = ""};
    ty_result result = matrix_find_reference(run, folder, row);
    if (result == TY_OK) result = take_features(run, path, out);
    if (result != TY_OK) return result;
    memcpy(out->name, row->name, sizeof row->name);
    for (int32_t m = 0; m < AUTO_METHODS; ++m) ty_terms_of(&out->features, m, out->terms[m]);
    for (int32_t m = 0; m < AUTO_METHODS; ++m)
        if (!take_method(row, m, &out->features, &out->methods[m])) {
            cli_fail(CLI_FAILED, "%s, %s: nothing is stored; 'make matrix' measures it", row->name, auto_methods[m]);
            return TY_ERROR_INPUT;
        }
    return TY_OK;
}

/* ---- judging ---- */

/* Errors of structure of scenes that have none measured are those of the fit. */
static void take_fine(study* of) {
    const ty_choice_model model = {AUTO_METHODS, of->methods}; /* those left out, too */
    for (int32_t i = 0; i < of->count; ++i)
        for (int32_t m = 1; m < AUTO_METHODS; ++m) {
            auto_measured* measured = &of->rows[i].methods[m];
            measured->fine_fitted =
                measured->fine > 0 ? measured->fine : ty_expect_fine(&model, m, &of->rows[i].features);
        }
}

static void judge(study* of) {
    for (int32_t i = 0; i < of->count; ++i) {
        ty_method_model methods[AUTO_METHODS];
        const ty_choice_model others = {AUTO_CANDIDATES, methods}, all = {AUTO_CANDIDATES, of->methods};
        auto_model_fit(of->rows, of->count, i, methods);
        for (int s = 0; s < SIZES; ++s) {
            const auto_row* row = &of->rows[i];
            of->held_out[i][s] = auto_model_judge(row, &row->features, &others, &sizes[s]);
            of->untried[i][s] = auto_model_judge(row, &row->untried, &others, &sizes[s]);
            of->fitted[i][s] = auto_model_judge(row, &row->features, &all, &sizes[s]);
        }
    }
}

/* Geometric mean of the losses of one method for all scenes. */
static double loss_of(const study* of, int32_t method, int size, bool large) {
    double sum = 0;
    int32_t count = 0;
    for (int32_t i = 0; i < of->count; ++i) {
        if (!of->rows[i].methods[method].rendered) continue;
        if (large && !(of->rows[i].methods[0].large.seconds > 0)) continue;
        const ty_expectation measured = auto_measured_at(&of->rows[i], method, &sizes[size]);
        sum += log(ty_cost_of(&measured) / ty_cost_of(&of->held_out[i][size].best_measured));
        ++count;
    }
    return exp(sum / fmax(count, 1));
}

/* Statistics of all scenes at one size. */
typedef struct summary {
    double loss, worst, error_factor, time_factor; /* factors: root mean square, of expected over measured */
    int32_t count, best, wrong;                    /* choices that are the best; losses above 1.5 */
} summary;

/* measured: scenes alone that were measured at the larger size. */
static summary summarize(const study* of, const auto_judged judged[][SIZES], int size, bool measured) {
    summary out = {.worst = 1};
    double losses = 0, errors = 0, times = 0;
    int32_t count = 0;
    for (int32_t i = 0; i < of->count; ++i) {
        const auto_judged* one = &judged[i][size];
        if (measured && !(of->rows[i].methods[0].large.seconds > 0)) continue;
        ++count;
        const double error =
            log(hypot(one->expected.error, ty_error_unseen) / hypot(one->measured.error, ty_error_unseen));
        const double time =
            log((one->expected.seconds + ty_seconds_unfelt) / (one->measured.seconds + ty_seconds_unfelt));
        losses += log(one->loss);
        errors += error * error;
        times += time * time;
        out.worst = fmax(out.worst, one->loss);
        out.best += one->chosen == one->best;
        out.wrong += one->loss > 1.5;
    }
    out.count = count;
    out.loss = exp(losses / fmax(count, 1));
    out.error_factor = exp(sqrt(errors / fmax(count, 1)));
    out.time_factor = exp(sqrt(times / fmax(count, 1)));
    return out;
}

/* ---- output ---- */

static ty_result print_model(ty_context* context, FILE* file, const void* user) {
    const study* of = user;
    (void)context;
    fputs("/* Coefficients of the expected errors and times of methods, made by `make auto-model`. */\n"
          "#include \"choose/predict.h\"\n\n/* clang-format off */\nstatic const ty_method_model methods[] = {\n",
          file);
    for (int32_t m = 0; m < AUTO_CANDIDATES; ++m) {
        static const char* const fits[TY_FITS] = {"TY_FIT_ERROR",   "TY_FIT_SOLVE", "TY_FIT_VIEW",
                                                  "TY_FIT_SURFACE", "TY_FIT_FINE",  "TY_FIT_UNTRIED"};
        static const char* const terms[TY_TERMS] = {
            "ONE",  "NOISE",       "VERTICES", "SURFACE_NOISE", "SURFACE_VERTICES", "MULTIPLE",    "FORWARD",
            "CELL", "SCATTERINGS", "ENCLOSED", "SURFACES",      "PLACED_LIGHT",     "ENVIRONMENT", "HETEROGENEOUS",
            "SPAN", "LIGHTS",      "VOXELS",   "TRIAL",         "TRIAL_NOISE"};
        fprintf(file, "    {\"%s\",\n     {", auto_methods[m]);
        for (int f = 0; f < TY_FITS; ++f) {
            bool first = true;
            fprintf(file, "%s[%s] = {", f > 0 ? ",\n      " : "", fits[f]);
            for (int t = 0; t < TY_TERMS; ++t) {
                if (of->methods[m].terms[f][t] == 0 && t > 0) continue;
                fprintf(file, "%s[TY_TERM_%s] = %.4g", first ? "" : ", ", terms[t], of->methods[m].terms[f][t]);
                first = false;
            }
            fputs("}", file);
        }
        fputs("}},\n", file);
    }
    fputs("};\n/* clang-format on */\n\nconst ty_choice_model ty_fitted_model = {sizeof methods / sizeof methods[0], "
          "methods};\n",
          file);
    return TY_OK;
}

static void print_losses(FILE* file, const study* of, int size, bool measured) {
    const summary out = summarize(of, of->held_out, size, measured), in = summarize(of, of->fitted, size, measured);
    fprintf(file, "\n| %s%s | %.3f | %.2f | %d | %d of %d | %.3f | %.3f | %.2f | %.2f |", size_names[size],
            measured ? ", scenes measured at that size" : "", out.loss, out.worst, out.wrong, out.best, out.count,
            summarize(of, of->untried, size, measured).loss, in.loss, out.error_factor, out.time_factor);
    for (int32_t m = 0; m < AUTO_METHODS; ++m) fprintf(file, " %.2f |", loss_of(of, m, size, measured));
}

static void print_summary(FILE* file, const study* of) {
    fputs("| picture | mean loss | largest | above 1.5 | the best chosen | without trials: mean loss | not held out: "
          "mean "
          "loss | error, factor | time, factor |",
          file);
    for (int32_t m = 0; m < AUTO_METHODS; ++m) fprintf(file, " always `%s` |", auto_methods[m]);
    fputs("\n|---|---|---|---|---|---|---|---|---|", file);
    for (int32_t m = 0; m < AUTO_METHODS; ++m) fputs("---|", file);
    for (int s = 0; s < SIZES; ++s) print_losses(file, of, s, false);
    print_losses(file, of, LISTED, true);
    fputs("\n", file);
}

static ty_result print_tables(ty_context* context, FILE* file, const void* user) {
    const study* of = user;
    (void)context;
    print_summary(file, of);
    fprintf(file,
            "\nScenes whose loss is above 1.2, held out, %s:\n\n| scene | choice | expected error | time, s | measured "
            "error "
            "| time, s | best | its error | time, s | loss |\n|---|---|---|---|---|---|---|---|---|---|\n",
            size_names[LISTED]);
    for (int32_t i = 0; i < of->count; ++i) {
        const auto_judged* one = &of->held_out[i][LISTED];
        if (one->loss <= 1.2) continue;
        fprintf(file, "| %s | `%s` | %.3f | %.2g | %.3f | %.2g | `%s` | %.3f | %.2g | %.2f |\n", of->rows[i].name,
                auto_methods[one->chosen], one->expected.error, one->expected.seconds, one->measured.error,
                one->measured.seconds, auto_methods[one->best], one->best_measured.error, one->best_measured.seconds,
                one->loss);
    }
    return TY_OK;
}

static ty_result write_files(figure_run* run, const study* of) {
    char path[MATRIX_PATH_SIZE];
    snprintf(path, sizeof path, "%s/model_table.c", run->options->folder);
    ty_result result = cli_write_text_file(run->session->context, path, print_model, of);
    snprintf(path, sizeof path, "%s/model_tables.md", run->options->folder);
    if (result == TY_OK) result = cli_write_text_file(run->session->context, path, print_tables, of);
    return result;
}

static void show(figure_run* run, const study* of) {
    plot_table table;
    if (plot_create_table(1 + SIZES, 5, 1, &table) != TY_OK) return;
    static const char* const heads[5] = {"picture", "mean loss", "largest", "the best chosen",
                                         "not held out: mean loss"};
    for (int c = 0; c < 5; ++c) plot_set_cell(&table, 0, c, "%s", heads[c]);
    for (int s = 0; s < SIZES; ++s) {
        const summary out = summarize(of, of->held_out, s, false), in = summarize(of, of->fitted, s, false);
        plot_set_cell(&table, 1 + s, 0, "%s", size_names[s]);
        plot_set_cell(&table, 1 + s, 1, "%.3f", out.loss);
        plot_set_cell(&table, 1 + s, 2, "%.2f", out.worst);
        plot_set_cell(&table, 1 + s, 3, "%d of %d", out.best, of->count);
        plot_set_cell(&table, 1 + s, 4, "%.3f", in.loss);
        figure_notes(
            run, size_names[s], {"mean loss held out, geometric", "1", out.loss}, {"largest loss", "1", out.worst},
            {"mean loss without trials, geometric", "1", summarize(of, of->untried, s, false).loss},
            {"mean loss not held out, geometric", "1", in.loss}, {"expected error, factor", "1", out.error_factor},
            {"expected time, factor", "1", out.time_factor});
    }
    plot_page_table(&run->page, &table);
    plot_free_table(&table);
}

ty_result figure_auto_model(figure_run* run) {
    char folder[FIGURE_PATH_SIZE];
    matrix_table table = {0};
    study* of = calloc(1, sizeof *of);
    if (of == NULL) return TY_ERROR_MEMORY;
    ty_result result = matrix_open(run, folder, &table);
    for (int32_t i = 0; i < table.row_count && result == TY_OK; ++i) {
        auto_row* row = &of->rows[of->count];
        result = take_row(run, folder, &table.rows[i], row);
        of->count += row->features.trial_noise > 0; /* without media there is nothing to choose */
    }
    matrix_close(&table);
    if (result == TY_OK) {
        auto_model_fit(of->rows, of->count, -1, of->methods);
        take_fine(of);
        judge(of);
        result = write_files(run, of);
    }
    if (result == TY_OK) show(run, of);
    figure_caption(
        run,
        "Method auto: loss of its choices on the %d scenes of the matrix, each by a model fitted to the others. "
        "Loss: error times the root of time, over that of the best method.",
        of->count);
    free(of);
    return result;
}
