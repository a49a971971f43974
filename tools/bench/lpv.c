/* tyndall bench lpv: injection and propagation as in the paper's Table 1, scaling of propagation with cells, and a
 * complete frame. */
#include "bench/tables.h"
#include "scenes/scenes.h"
#include "method/lpv/lpv_method.h"
#include "method/lpv/propagate/propagate.h"

#include <math.h>
#include <string.h>

enum {
    SIZES = 2,
    MODES = 2,
    COLUMNS = SIZES * MODES,
    GROWTH = 4,
    RUNS_MAX = 99,
    ITERATIONS = 8,
    WIDTH = 1280,
    HEIGHT = 720
};

/* Homogeneous fog around a point light: resolution^3 cells. */
static const int32_t sizes[SIZES] = {32, 64};
static const ty_lpv_mode modes[MODES] = {TY_LPV_MODE_LINKS, TY_LPV_MODE_PUBLISHED};
static const char* const mode_names[MODES] = {"links", "published"};

/* ---- stages ---- */

enum {
    MAPS,
    REFLECTED,
    BLOCKERS,
    SCATTERED,
    INJECTION,
    SHADOWS,
    MEDIA,
    PREPARE,
    PROPAGATE,
    GATHER,
    PROPAGATION,
    STAGES
};

/* Names, and milliseconds in the paper; 0: not given. The paper also gathers the injected light from textures, 0.02 and
 * 0.16 ms; here it is injected directly into the lattice. */
static const struct {
    const char *name, *key;
    double paper[SIZES];
} stages[STAGES] = {
    [MAPS] = {"maps of lights", "map_seconds", {0, 0}},
    [REFLECTED] = {"reflected", "reflected_seconds", {0.87, 0.84}},
    [BLOCKERS] = {"blockers", "blocker_seconds", {4.5, 3.9}},
    [SCATTERED] = {"single-scattered", "scattered_seconds", {0.47, 0.58}},
    [INJECTION] = {"injection, total", "injection_seconds", {5.9, 5.2}},
    [SHADOWS] = {"maps for images", "shadow_seconds", {0, 0}},
    [MEDIA] = {"media on cells", "medium_seconds", {0, 0}},
    [PREPARE] = {"prepare", "prepare_seconds", {0.4, 2.8}},
    [PROPAGATE] = {"propagate, 8 times", "propagate_seconds", {1.49, 12.3}},
    [GATHER] = {"copy results", "gather_seconds", {0.18, 1.24}},
    [PROPAGATION] = {"propagation, total", "propagation_seconds", {2.5, 17}},
};

/* Seconds: medians. */
typedef struct timed {
    double seconds[STAGES];
    double total;
    ty_lpv_stats stats; /* of the last run */
} timed;

static void read_stages(const ty_lpv_stats* stats, double seconds[STAGES]) {
    seconds[MAPS] = stats->map_seconds;
    seconds[REFLECTED] = stats->reflected_seconds;
    seconds[BLOCKERS] = stats->blocker_seconds;
    seconds[SCATTERED] = stats->scattered_seconds;
    seconds[INJECTION] = ty_lpv_injection_seconds(stats);
    seconds[SHADOWS] = stats->shadow_seconds;
    seconds[MEDIA] = stats->medium_seconds;
    seconds[PREPARE] = stats->prepare_seconds;
    seconds[PROPAGATE] = stats->propagate_seconds;
    seconds[GATHER] = stats->gather_seconds;
    seconds[PROPAGATION] = ty_lpv_propagation_seconds(stats);
}

/* Runs `runs` timed solves after a warm-up solve. */
static ty_result time_def(const bench_session* bench, const ty_scene* scene, const ty_lpv_def* def, timed* out) {
    double seconds[STAGES + 1][RUNS_MAX];
    const int runs = bench->options->runs;
    out->stats = ty_default_lpv_stats();
    for (int run = -1; run < runs; ++run) {
        ty_lpv* light = NULL;
        double taken[STAGES];
        const ty_result result = ty_lpv_solve(scene, def, &light, &out->stats);
        ty_lpv_destroy(light);
        if (result != TY_OK) return result;
        read_stages(&out->stats, taken);
        const int slot = run < 0 ? 0 : run;
        for (int s = 0; s < STAGES; ++s) seconds[s][slot] = taken[s];
        seconds[STAGES][slot] = out->stats.seconds;
    }
    for (int s = 0; s < STAGES; ++s) out->seconds[s] = bench_median(seconds[s], runs);
    out->total = bench_median(seconds[STAGES], runs);
    return TY_OK;
}

static ty_lpv_def table_def(ty_lpv_mode mode, int32_t resolution) {
    ty_lpv_def def = ty_default_lpv_def();
    def.mode = mode;
    def.resolution = resolution;
    def.iterations = ITERATIONS;
    return def;
}

/* ---- fraction of peak performance ---- */

static double cells_of(const ty_lpv_stats* stats) {
    return (double)stats->size[0][0] * stats->size[0][1] * stats->size[0][2];
}

/* A multiply-add is two operations; operations for nearby surfaces are not counted. */
static double propagation_gflops(const timed* t) {
    const double operations = 2.0 * ty_lattice_step_operations(2);
    return 1e-9 * operations * cells_of(&t->stats) * t->stats.iterations / t->seconds[PROPAGATE];
}

static double mrays(const ty_lpv_stats* stats) {
    return stats->ray_seconds > 0 ? 1e-6 * (double)stats->rays / stats->ray_seconds : 0;
}

/* ---- Table 1 ---- */

static void print_table(const bench_session* bench, const char* name, const timed table[COLUMNS], double peak) {
    json_writer* json = bench->json;
    json_open_array(json, name);
    for (int i = 0; i < COLUMNS; ++i) {
        const timed* t = &table[i];
        const int32_t* size = t->stats.size[0];
        json_open_object(json, NULL);
        json_text(json, "mode", mode_names[i / SIZES]);
        json_numbers(json, "size", (const double[]){size[0], size[1], size[2]}, 3);
        for (int s = 0; s < STAGES; ++s) json_number(json, stages[s].key, t->seconds[s]);
        bench_numbers(json, {"seconds", t->total}, {"propagate_gflops", propagation_gflops(t)},
                      {"fraction_of_peak", propagation_gflops(t) / peak}, {"mrays", mrays(&t->stats)});
        json_close_object(json);
    }
    json_close_array(json);
}

static ty_result time_table(const bench_session* bench, const ty_scene* scene, timed table[COLUMNS]) {
    ty_result result = TY_OK;
    for (int i = 0; i < COLUMNS && result == TY_OK; ++i) {
        const ty_lpv_def def = table_def(modes[i / SIZES], sizes[i % SIZES]);
        result = time_def(bench, scene, &def, &table[i]);
    }
    return result;
}

static ty_result bench_scene_table(const bench_session* bench, const char* name, const ty_scene* scene, double peak) {
    timed table[COLUMNS];
    const ty_result result = time_table(bench, scene, table);
    if (result == TY_OK) print_table(bench, name, table, peak);
    return result;
}

/* ---- scaling ---- */

static void print_growth(const bench_session* bench, int mode, const timed t[GROWTH]) {
    const double more = log(cells_of(&t[GROWTH - 1].stats) / cells_of(&t[0].stats));
    const double exponent = log(t[GROWTH - 1].seconds[PROPAGATE] / t[0].seconds[PROPAGATE]) / more;
    json_open_object(bench->json, mode_names[mode]);
    for (int i = 0; i < GROWTH; ++i) {
        char key[32];
        snprintf(key, sizeof key, "propagate_seconds_%d", (int)t[i].stats.size[0][0]);
        json_number(bench->json, key, t[i].seconds[PROPAGATE]);
    }
    json_number(bench->json, "exponent", exponent);
    json_close_object(bench->json);
}

/* Table 1's, on a GTX 480. */
static void print_paper(const bench_session* bench) {
    json_open_object(bench->json, "paper_ms");
    for (int s = 0; s < STAGES; ++s)
        if (stages[s].paper[0] > 0) json_numbers(bench->json, stages[s].name, stages[s].paper, SIZES);
    json_close_object(bench->json);
}

static ty_result bench_growth(const bench_session* bench, const ty_scene* scene) {
    static const int32_t sides[2][GROWTH] = {{24, 32, 64, 96}, {8, 12, 16, 24}}; /* the latter with --quick */
    ty_result result = TY_OK;
    json_open_object(bench->json, "growth");
    for (int m = 0; m < MODES && result == TY_OK; ++m) {
        timed t[GROWTH];
        for (int i = 0; i < GROWTH && result == TY_OK; ++i) {
            const ty_lpv_def def = table_def(modes[m], sides[bench->options->quick][i]);
            result = time_def(bench, scene, &def, &t[i]);
        }
        if (result == TY_OK) print_growth(bench, m, t);
    }
    json_close_object(bench->json);
    return result;
}

/* ---- a frame ---- */

enum { ALL, SOLVE, VIEW, SURFACES, MARCH, SINGLE, COMPOSE, PARTS };

static void print_frame(const bench_session* bench, const char* name, const ty_lpv_def* def, double seconds[PARTS]) {
    static const char* const keys[PARTS] = {"seconds",       "solve_seconds",  "view_seconds",   "surface_seconds",
                                            "march_seconds", "single_seconds", "compose_seconds"};
    char key[64];
    snprintf(key, sizeof key, "a frame of %s", name);
    json_open_object(bench->json, key);
    json_text(bench->json, "scene", name);
    json_numbers(bench->json, "resolution", (const double[]){def->width, def->height}, 2);
    for (int p = 0; p < PARTS; ++p) json_number(bench->json, keys[p], seconds[p]);
    json_close_object(bench->json);
}

/* The default mode, 32 cells along the longest side, without reuse between frames. */
static ty_result bench_frame(const bench_session* bench, const char* name, const ty_scene* scene) {
    double seconds[PARTS][RUNS_MAX], medians[PARTS];
    const int runs = bench->options->runs;
    int32_t size[2];
    ty_lpv_def def = ty_default_lpv_def();
    bench_pixels(bench->options, WIDTH, HEIGHT, size);
    def.width = size[0];
    def.height = size[1];
    for (int run = -1; run < runs; ++run) {
        ty_image* image = NULL;
        ty_lpv_stats stats = ty_default_lpv_stats();
        const ty_result result = ty_lpv_render(scene, &def, &image, &stats);
        ty_image_destroy(image);
        if (result != TY_OK) return result;
        const int slot = run < 0 ? 0 : run;
        seconds[ALL][slot] = stats.seconds;
        seconds[SOLVE][slot] = stats.seconds - ty_lpv_image_seconds(&stats);
        seconds[VIEW][slot] = stats.view_seconds;
        seconds[SURFACES][slot] = stats.surface_seconds;
        seconds[MARCH][slot] = stats.march_seconds;
        seconds[SINGLE][slot] = stats.single_seconds;
        seconds[COMPOSE][slot] = stats.compose_seconds;
    }
    for (int p = 0; p < PARTS; ++p) medians[p] = bench_median(seconds[p], runs);
    print_frame(bench, name, &def, medians);
    return TY_OK;
}

/* ---- bench ---- */

/* One light, the sun, as in the paper. */
static const char one_light[] =
    "lights=[{\"type\": \"directional\", \"direction\": [-0.3, -1, 0.3], \"irradiance\": [20, 18.5, 16]}]";

static ty_result bench_scene(const bench_session* bench, lpv_scene which, const char* name, const char* change,
                             bool frame, double peak) {
    ty_scene* scene = NULL;
    ty_result result = tools_load_scene(bench->session->context, lpv_scene_files[which], bench->options->data, &change,
                                        change != NULL ? 1 : 0, &scene);
    if (result == TY_OK) result = bench_scene_table(bench, name, scene, peak);
    if (result == TY_OK && frame) result = bench_frame(bench, name, scene);
    ty_scene_destroy(scene);
    return result;
}

static ty_result bench_scenes(const bench_session* bench, double peak) {
    const bool sponza = tools_has_data(bench->options->data, SPONZA_FILE);
    ty_result result = bench_scene(bench, LPV_ATRIUM, lpv_scene_names[LPV_ATRIUM], NULL, !sponza, peak);
    if (result == TY_OK && sponza) result = bench_scene(bench, LPV_SPONZA, "Sponza, one light", one_light, true, peak);
    if (result == TY_OK && sponza)
        result = bench_scene(bench, LPV_SPONZA, lpv_scene_names[LPV_SPONZA], NULL, true, peak);
    return result;
}

int bench_lpv(const bench_session* bench) {
    ty_scene* synthetic = NULL;
    const double peak = bench_fma_gflops(bench->session->context);
    ty_result result = peak > 0 ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK)
        result = tools_load_scene(bench->session->context, "bench_lamp_in_fog", NULL, NULL, 0, &synthetic);
    if (result == TY_OK) print_paper(bench);
    if (result == TY_OK) result = bench_scene_table(bench, "synthetic", synthetic, peak);
    if (result == TY_OK) result = bench_growth(bench, synthetic);
    ty_scene_destroy(synthetic);
    if (result == TY_OK) result = bench_scenes(bench, peak);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}

/* ---- the table of a figure ---- */

static void fill_table(const timed table[COLUMNS], bench_table* out) {
    out->rows = STAGES;
    out->columns = COLUMNS;
    out->paper_columns = SIZES;
    for (int i = 0; i < COLUMNS; ++i) {
        const int32_t* size = table[i].stats.size[0];
        snprintf(out->titles[i], BENCH_TABLE_TITLE, "%s %d×%d×%d", mode_names[i / SIZES], (int)size[0], (int)size[1],
                 (int)size[2]);
    }
    for (int i = 0; i < SIZES; ++i) snprintf(out->paper_titles[i], BENCH_TABLE_TITLE, "%d³", (int)sizes[i]);
    for (int s = 0; s < STAGES; ++s) {
        out->row_names[s] = stages[s].name;
        out->units[s] = "ms";
        for (int i = 0; i < COLUMNS; ++i) out->measured[s][i] = 1e3 * table[i].seconds[s];
        for (int i = 0; i < SIZES; ++i) out->paper[s][i] = stages[s].paper[i];
    }
}

ty_result bench_lpv_table(const bench_session* bench, bench_table* out) {
    const bool sponza = tools_has_data(bench->options->data, SPONZA_FILE);
    const lpv_scene which = sponza ? LPV_SPONZA : LPV_ATRIUM;
    const char* change = one_light;
    ty_scene* scene = NULL;
    timed table[COLUMNS];
    *out = (bench_table){.paper_machine = "a GeForce GTX 480"};
    ty_result result = tools_load_scene(bench->session->context, lpv_scene_files[which], bench->options->data, &change,
                                        sponza ? 1 : 0, &scene);
    if (result == TY_OK) result = time_table(bench, scene, table);
    if (result == TY_OK) fill_table(table, out);
    ty_scene_destroy(scene);
    snprintf(out->setting, sizeof out->setting, "%s%s, everything anew each time", lpv_scene_names[which],
             sponza ? ", one light" : "");
    return result;
}
