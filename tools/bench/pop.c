/* tyndall bench pop: the paper's typical setting (Fig. 14), stage by stage, in published and in default mode, and
 * scaling with ordinates, cells and iterations. */
#include "bench/tables.h"
#include "scenes/scenes.h"

#include <math.h>
#include <string.h>

enum {
    ORDINATES = 64,
    RESOLUTION = 20,
    ITERATIONS = 10,
    RESIDUUM_ITERATIONS = 20,
    WIDTH = 1024,
    RUNS_MAX = 99,
    SCALES = 3,
    MODES = 2
};

/* The coefficients of the paper's smoke (Fig. 11), in a volume of 10 m. */
static const ty_pop_mode modes[MODES] = {TY_POP_MODE_SPLIT, TY_POP_MODE_PUBLISHED};
static const char* const mode_names[MODES] = {"split", "published"};

/* ---- stages ---- */

enum { MEDIUM, IMPORTANCE, DIRECTIONS, INITIAL, PROPAGATION, RESIDUUM, MERGE, BEFORE, MARCH, STAGES };

/* Names, and milliseconds in the paper; 0: not given. */
static const struct {
    const char *name, *key;
    double paper;
} stages[STAGES] = {
    [MEDIUM] = {"medium", "medium_seconds", 0},
    [IMPORTANCE] = {"importance", "importance_seconds", 5},
    [DIRECTIONS] = {"ordinates", "ordinate_seconds", 2},
    [INITIAL] = {"initialisation", "initial_seconds", 2},
    [PROPAGATION] = {"propagation", "propagation_seconds", 12},
    [RESIDUUM] = {"residuum, diffusion", "residuum_seconds", 2},
    [MERGE] = {"merging", "merge_seconds", 4},
    [BEFORE] = {"all before the march", "before_march_seconds", 27},
    [MARCH] = {"march", "march_seconds", 5},
};

/* Seconds: medians. */
typedef struct timed {
    double seconds[STAGES];
    ty_pop_stats stats; /* of the last run */
} timed;

static void read_stages(const ty_pop_stats* stats, int run, double seconds[STAGES][RUNS_MAX]) {
    seconds[MEDIUM][run] = stats->medium_seconds;
    seconds[IMPORTANCE][run] = stats->importance_seconds;
    seconds[DIRECTIONS][run] = stats->ordinate_seconds;
    seconds[INITIAL][run] = stats->initial_seconds;
    seconds[PROPAGATION][run] = stats->propagation_seconds;
    seconds[RESIDUUM][run] = stats->residuum_seconds;
    seconds[MERGE][run] = stats->merge_seconds;
    seconds[BEFORE][run] = stats->seconds - stats->march_seconds;
    seconds[MARCH][run] = stats->march_seconds;
}

/* Runs `runs` timed renders, or solves without an image, after a warm-up run. */
static ty_result time_def(const bench_session* bench, const ty_scene* scene, const ty_pop_def* def, bool image,
                          timed* out) {
    static double seconds[STAGES][RUNS_MAX];
    const int runs = bench->options->runs;
    ty_result result = TY_OK;
    out->stats = ty_default_pop_stats();
    for (int run = -1; run < runs && result == TY_OK; ++run) {
        ty_image* picture = NULL;
        ty_pop* light = NULL;
        result =
            image ? ty_pop_render(scene, def, &picture, &out->stats) : ty_pop_solve(scene, def, &light, &out->stats);
        ty_image_destroy(picture);
        ty_pop_destroy(light);
        read_stages(&out->stats, run < 0 ? 0 : run, seconds);
    }
    for (int s = 0; s < STAGES && result == TY_OK; ++s) out->seconds[s] = bench_median(seconds[s], runs);
    return result;
}

static ty_pop_def typical_def(const bench_session* bench, ty_pop_mode mode) {
    int32_t size[2];
    ty_pop_def def = ty_default_pop_def();
    def.mode = mode;
    def.ordinates = ORDINATES;
    def.resolution = RESOLUTION;
    def.iterations = ITERATIONS;
    def.residuum_iterations = RESIDUUM_ITERATIONS; /* as in Fig. 8 */
    bench_pixels(bench->options, WIDTH, WIDTH, size);
    def.width = size[0];
    def.height = size[1];
    return def;
}

/* ---- fraction of peak performance ---- */

/* Floating-point operations of one cell, channel and iteration (method/pop/published/propagate_kernel.c,
 * grid/lobe.k.h); a division counts as one. Scatter to neighbors: the patches of Eq. 2-3 with two inverse roots of 9
 * each, 42; radiance and radiance times mean cosine for front, sides and back with half of the attenuation, 12. Gather
 * from neighbors: sums over six neighbors and the other half of the attenuation, 14; the new mean cosine and the
 * transmitted radiance, 4; the accumulated radiance (Eq. 7-8), 24. */
enum { OPERATIONS = 42 + 12 + 14 + 4 + 24 };

static double propagation_gflops(const timed* t) {
    const double cells = (double)t->stats.size[0] * t->stats.size[1] * t->stats.size[2];
    return 1e-9 * OPERATIONS * cells * 3 * t->stats.ordinates * t->stats.iterations / t->seconds[PROPAGATION];
}

/* ---- the typical setting ---- */

static void print_typical(const bench_session* bench, const timed typical[MODES], double peak) {
    json_open_object(bench->json, "typical");
    for (int m = 0; m < MODES; ++m) {
        json_open_object(bench->json, mode_names[m]);
        for (int s = 0; s < STAGES; ++s) json_number(bench->json, stages[s].key, typical[m].seconds[s]);
        bench_numbers(
            bench->json, {"ordinates", typical[m].stats.ordinates}, {"iterations", typical[m].stats.iterations},
            {"residuum_iterations", typical[m].stats.residuum_iterations}, {"bytes", typical[m].stats.memory_bytes});
        if (modes[m] == TY_POP_MODE_PUBLISHED) {
            bench_numbers(bench->json, {"propagation_gflops", propagation_gflops(&typical[m])},
                          {"fraction_of_peak", propagation_gflops(&typical[m]) / peak});
        }
        json_close_object(bench->json);
    }
    json_open_object(bench->json, "paper_ms"); /* on a GTX 770 */
    for (int s = 0; s < STAGES; ++s)
        if (stages[s].paper > 0) json_number(bench->json, stages[s].name, stages[s].paper);
    json_close_object(bench->json);
    bench_numbers(bench->json, {"fma_gflops", peak},
                  {"split_over_published", typical[0].seconds[BEFORE] / typical[1].seconds[BEFORE]});
    json_close_object(bench->json);
}

static ty_result time_typical(const bench_session* bench, const ty_scene* scene, timed typical[MODES]) {
    ty_result result = TY_OK;
    for (int m = 0; m < MODES && result == TY_OK; ++m) {
        const ty_pop_def def = typical_def(bench, modes[m]);
        result = time_def(bench, scene, &def, true, &typical[m]);
    }
    return result;
}

static ty_result bench_typical(const bench_session* bench, const ty_scene* scene) {
    timed typical[MODES];
    const double peak = bench_fma_gflops(bench->session->context);
    if (!(peak > 0)) return TY_ERROR_MEMORY;
    const ty_result result = time_typical(bench, scene, typical);
    if (result == TY_OK) print_typical(bench, typical, peak);
    return result;
}

/* ---- scaling ---- */

/* The number of cells grows with the third power of the setting. */
static const struct {
    const char* name;
    int32_t values[SCALES];
    double power;
} scales[] = {{"ordinates", {16, 64, 256}, 1}, {"resolution", {10, 20, 40}, 3}, {"iterations", {10, 20, 40}, 1}};
enum { SCALED = sizeof scales / sizeof scales[0], ITERATED = 2 };

/* Propagation in the ordinates' grids, whose time should be proportional. */
static double own_seconds(const timed* t) {
    return t->seconds[INITIAL] + t->seconds[PROPAGATION];
}

static void print_scaled(const bench_session* bench, int scale, int mode, const timed t[SCALES]) {
    const double more = pow((double)scales[scale].values[SCALES - 1] / scales[scale].values[0], scales[scale].power);
    const double exponent = log(own_seconds(&t[SCALES - 1]) / own_seconds(&t[0])) / log(more);
    json_open_object(bench->json, NULL);
    json_text(bench->json, "mode", mode_names[mode]);
    json_text(bench->json, "scaled", scales[scale].name);
    json_numbers(bench->json, "values",
                 (const double[]){scales[scale].values[0], scales[scale].values[1], scales[scale].values[2]}, SCALES);
    json_numbers(bench->json, "seconds", (const double[]){own_seconds(&t[0]), own_seconds(&t[1]), own_seconds(&t[2])},
                 SCALES);
    json_numbers(bench->json, "before_march_seconds",
                 (const double[]){t[0].seconds[BEFORE], t[1].seconds[BEFORE], t[2].seconds[BEFORE]}, SCALES);
    json_number(bench->json, "exponent", exponent);
    json_close_object(bench->json);
}

static ty_result time_scale(const bench_session* bench, const ty_scene* scene, int scale, int mode) {
    timed t[SCALES];
    ty_result result = TY_OK;
    for (int i = 0; i < SCALES && result == TY_OK; ++i) {
        ty_pop_def def = typical_def(bench, modes[mode]);
        const int32_t value = scales[scale].values[i];
        if (strcmp(scales[scale].name, "ordinates") == 0) def.ordinates = value;
        if (strcmp(scales[scale].name, "resolution") == 0) def.resolution = value;
        if (strcmp(scales[scale].name, "iterations") == 0) def.iterations = value;
        result = time_def(bench, scene, &def, false, &t[i]);
    }
    if (result == TY_OK) print_scaled(bench, scale, mode, t);
    return result;
}

static ty_result bench_scales(const bench_session* bench, const ty_scene* scene) {
    ty_result result = TY_OK;
    json_open_array(bench->json, "scales");
    for (int m = 0; m < MODES && result == TY_OK; ++m)
        for (int scale = 0; scale < SCALED && result == TY_OK; ++scale)
            if (scale != ITERATED || modes[m] == TY_POP_MODE_PUBLISHED) result = time_scale(bench, scene, scale, m);
    json_close_array(bench->json);
    return result;
}

static ty_result load_scene(const bench_session* bench, ty_scene** out) {
    return tools_load_scene(bench->session->context, "bench_smoke", NULL, NULL, 0, out);
}

int bench_pop(const bench_session* bench) {
    ty_scene* scene = NULL;
    ty_result result = load_scene(bench, &scene);
    if (result == TY_OK) result = bench_typical(bench, scene);
    if (result == TY_OK) result = bench_scales(bench, scene);
    ty_scene_destroy(scene);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}

ty_result bench_pop_table(const bench_session* bench, bench_table* out) {
    ty_scene* scene = NULL;
    timed typical[MODES];
    *out = (bench_table){.rows = STAGES, .columns = MODES, .paper_columns = 1, .paper_machine = "a GeForce GTX 770"};
    ty_result result = load_scene(bench, &scene);
    if (result == TY_OK) result = time_typical(bench, scene, typical);
    ty_scene_destroy(scene);
    for (int m = 0; m < MODES; ++m) snprintf(out->titles[m], BENCH_TABLE_TITLE, "%s", mode_names[m]);
    snprintf(out->paper_titles[0], BENCH_TABLE_TITLE, "published");
    for (int s = 0; s < STAGES && result == TY_OK; ++s) {
        out->row_names[s] = stages[s].name;
        out->units[s] = "ms";
        out->paper[s][0] = stages[s].paper;
        for (int m = 0; m < MODES; ++m) out->measured[s][m] = 1e3 * typical[m].seconds[s];
    }
    snprintf(out->setting, sizeof out->setting,
             "Smoke of noise under a sky, %d ordinates of %d³ cells, %d iterations, RGB coefficients", ORDINATES,
             RESOLUTION, ITERATIONS);
    return result;
}
