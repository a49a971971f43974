/* tyndall bench screen: screen-space scattering over a synthetic HDR image, compared with the time to stream the bytes
 * that it touches, with the naive method, and with the exact one. */
#include "bench/memory.h"
#include "bench/tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIZES = 4, CASES = 5, TABLE_CASES = BENCH_SCREEN_CASES, ROUNDS_PER_RUN = 3, ROUNDS_MAX = ROUNDS_PER_RUN * 99 };
enum { MEMORY_PARTS = 8 }; /* one slice per round, so that the next slice is in no cache */
enum { LEVELS = 6, WINDOW = 100, STRIP_ROWS = 100 };
enum { SCATTER_4 = 1, NAIVE = 4 }; /* baseline cases */

/* 1, 2, 4 and 8 million pixels. */
static const int32_t sizes[SIZES][2] = {{1250, 800}, {2000, 1000}, {2500, 1600}, {4000, 2000}};

/* ---- input image ---- */

typedef struct scene {
    int32_t width, height;
    float* floats; /* planes of R, G, B, distance, and three outputs */
    void* workspace;
    size_t workspace_size;
    double focal;
} scene;

static const struct {
    const char* name;
    ty_screen_variant variant;
    int32_t filter;
    bool naive;
} cases[TABLE_CASES] = {
    {"scatter 2x2", TY_SCREEN_SCATTER, 2, false}, {"scatter 4x4", TY_SCREEN_SCATTER, 4, false},
    {"scatter 6x6", TY_SCREEN_SCATTER, 6, false}, {"gather 4x4", TY_SCREEN_GATHER, 4, false},
    {"naive 4x4", TY_SCREEN_GATHER, 4, true},     {"gather 2x2", TY_SCREEN_GATHER, 2, false},
    {"gather 6x6", TY_SCREEN_GATHER, 6, false},
};

/* Haze of 50 m visibility, a little bluish. */
static ty_screen_def make_def(const scene* s, int index) {
    ty_screen_def def = ty_default_screen_def();
    const float sigma_s[3] = {0.068f, 0.072f, 0.078f};
    memcpy(def.sigma_s, sigma_s, sizeof sigma_s);
    for (int c = 0; c < 3; ++c) {
        def.sigma_a[c] = 0.002f;
        def.g[c] = 0.9f;
    }
    def.focal[0] = def.focal[1] = s->focal;
    def.variant = cases[index].variant;
    if (cases[index].naive) ty_screen_naive_def(&def);
    def.filter = cases[index].filter;
    def.levels = LEVELS;
    return def;
}

static float* plane(const scene* s, int index) {
    return s->floats + (size_t)index * (size_t)s->width * (size_t)s->height;
}

/* Rows [first, first + rows) of the scene. */
static ty_screen_image row_window(const scene* s, int32_t first, int32_t rows) {
    const size_t begin = (size_t)first * (size_t)s->width;
    ty_screen_image image = ty_default_screen_image();
    image.width = s->width;
    image.height = rows;
    image.distance = plane(s, 3) + begin;
    for (int c = 0; c < 3; ++c) {
        image.color.data[c] = plane(s, c) + begin;
        image.out.data[c] = plane(s, 4 + c) + begin;
    }
    image.color.row = image.out.row = image.distance_row = s->width;
    return image;
}

/* A street at night: boxes at steps of distance, a ground, a dim sky, and light sources a thousand times brighter. */
static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const scene* s = user;
    const float y = ((float)row + 0.5f) / (float)s->height;
    for (int32_t x = 0; x < s->width; ++x) {
        const float u = ((float)x + 0.5f) / (float)s->height;
        const int32_t house = (int32_t)(5 * u);
        const float roof = 0.25f + 0.05f * (float)(house * 7 % 5);
        const bool ground = y > 0.7f, wall = !ground && y > roof;
        const float distance = ground ? 6 / (y - 0.68f) : wall ? 12 + 9 * (float)(house * 3 % 7) : 0;
        const float a = fmodf(20 * u, 1) - 0.5f, b = fmodf(20 * y, 1) - 0.5f;
        const float light = wall && a * a + b * b < 0.01f ? 100 : 0;
        const float base = ground ? 0.1f : wall ? 0.2f + 0.1f * (float)(house % 3) : 0.02f + 0.05f * y;
        const size_t at = (size_t)row * (size_t)s->width + (size_t)x;
        plane(s, 0)[at] = base + light;
        plane(s, 1)[at] = 0.9f * base + 0.8f * light;
        plane(s, 2)[at] = 0.7f * base + 0.5f * light;
        plane(s, 3)[at] = distance;
    }
}

static bool open_scene(ty_context* context, int32_t width, int32_t height, scene* out) {
    *out = (scene){.width = width, .height = height, .focal = ty_screen_focal(height, 40)};
    out->floats = calloc((size_t)width * (size_t)height, 7 * sizeof(float));
    for (int i = 0; i < TABLE_CASES; ++i) {
        const ty_screen_def def = make_def(out, i);
        const size_t size = ty_screen_workspace(context, &def, width, height);
        if (size > out->workspace_size) out->workspace_size = size;
    }
    out->workspace_size = (out->workspace_size + 63) / 64 * 64;
    out->workspace = aligned_alloc(64, out->workspace_size + 64);
    if (out->floats == NULL || out->workspace == NULL) return false;
    memset(out->workspace, 0, out->workspace_size + 64); /* pages are faulted in before timing */
    ty_parallel_for(context, height, fill_row, out);
    return true;
}

static void close_scene(scene* s) {
    free(s->floats);
    free(s->workspace);
}

/* ---- measuring ---- */

typedef struct case_result {
    double seconds, steps[3]; /* medians */
    double bytes;
    int32_t levels;
} case_result;

typedef struct size_result {
    int32_t width, height;
    case_result cases[TABLE_CASES];
    double copy, triad; /* medians, bytes/s; 0: not measured */
} size_result;

static double median_of(const double* values, int count) {
    double sorted[ROUNDS_MAX];
    memcpy(sorted, values, sizeof *values * (size_t)count);
    return bench_median(sorted, count);
}

/* Timings of rounds, by case, for the medians. */
typedef struct rounds {
    int count, cases;
    double seconds[TABLE_CASES][ROUNDS_MAX], steps[TABLE_CASES][3][ROUNDS_MAX];
    double copy[ROUNDS_MAX], triad[ROUNDS_MAX];
} rounds;

static ty_result run_case(ty_context* context, const scene* s, int index, double* seconds, ty_screen_stats* stats) {
    const ty_screen_def def = make_def(s, index);
    const ty_screen_image image = row_window(s, 0, s->height);
    const double start = cli_wall_seconds();
    const ty_result result = ty_screen_apply(context, &def, &image, s->workspace, s->workspace_size, stats);
    *seconds = cli_wall_seconds() - start;
    return result;
}

/* All cases and the bandwidth are interleaved, so that other load affects all alike; the first round is not counted.
 * memory NULL: without the bandwidth. */
static ty_result run_rounds(ty_context* context, const scene* s, const bench_memory* memory, rounds* r,
                            size_result* out) {
    for (int round = -1; round < r->count; ++round) {
        const int to = round < 0 ? 0 : round;
        for (int i = 0; i < r->cases; ++i) {
            ty_screen_stats stats = ty_default_screen_stats();
            ty_result result = run_case(context, s, i, &r->seconds[i][to], &stats);
            if (result == TY_OK && cli_interrupted()) result = TY_CANCELLED;
            if (result != TY_OK) return result;
            for (int step = 0; step < 3; ++step) r->steps[i][step][to] = stats.step_seconds[step];
            out->cases[i].bytes = stats.memory_bytes;
            out->cases[i].levels = stats.levels;
        }
        if (memory == NULL) continue;
        const bench_memory_slice slice = {(round + 1) % MEMORY_PARTS, MEMORY_PARTS};
        r->copy[to] = bench_memory_copy(context, memory, slice, ty_context_threads(context));
        r->triad[to] = bench_memory_triad(context, memory, slice, ty_context_threads(context));
    }
    return TY_OK;
}

static ty_result measure_size(ty_context* context, const scene* s, const bench_memory* memory, int case_count,
                              int count, size_result* out) {
    *out = (size_result){.width = s->width, .height = s->height};
    rounds* r = calloc(1, sizeof *r);
    if (r == NULL) return TY_ERROR_MEMORY;
    r->count = count;
    r->cases = case_count;
    const ty_result result = run_rounds(context, s, memory, r, out);
    for (int i = 0; result == TY_OK && i < case_count; ++i) {
        out->cases[i].seconds = median_of(r->seconds[i], count);
        for (int step = 0; step < 3; ++step) out->cases[i].steps[step] = median_of(r->steps[i][step], count);
    }
    out->copy = median_of(r->copy, count);
    out->triad = median_of(r->triad, count);
    free(r);
    return result;
}

/* Total number of pixels in the windows around all pixels. */
static double window_pixels(int32_t width, int32_t height) {
    const int32_t sides[2] = {width, height};
    double product = 1;
    for (int axis = 0; axis < 2; ++axis) {
        double sum = 0;
        for (int32_t i = 0; i < sides[axis]; ++i)
            sum += fmin(i + WINDOW / 2, sides[axis] - 1) - fmax(i - WINDOW / 2 + 1, 0) + 1;
        product *= sum;
    }
    return product;
}

/* The exact method with a window, extrapolated from a central strip by the number of window pixels. */
static ty_result measure_reference(ty_context* context, const scene* s, bool full, double* seconds) {
    const int32_t rows = full || s->height < STRIP_ROWS ? s->height : STRIP_ROWS;
    const ty_screen_image image = row_window(s, (s->height - rows) / 2, rows);
    ty_screen_def def = make_def(s, SCATTER_4);
    def.variant = TY_SCREEN_REFERENCE;
    def.window = WINDOW;
    def.levels = TY_AUTO;
    const double start = cli_wall_seconds();
    const ty_result result = ty_screen_apply(context, &def, &image, NULL, 0, NULL);
    *seconds = (cli_wall_seconds() - start) * window_pixels(s->width, s->height) / window_pixels(s->width, rows);
    return result;
}

/* ---- printing ---- */

static double pixels_of(const size_result* size) {
    return (double)size->width * (double)size->height;
}

/* The ratio to the time of streaming the bytes, by copy or triad, whichever is faster. */
static double stream_ratio(const size_result* size, int index) {
    return size->cases[index].seconds * fmax(size->copy, size->triad) / size->cases[index].bytes;
}

static void print_size(json_writer* json, const size_result* size) {
    json_open_object(json, NULL);
    bench_numbers(json, {"width", size->width}, {"height", size->height}, {"copy_gb_per_second", 1e-9 * size->copy},
                  {"triad_gb_per_second", 1e-9 * size->triad});
    json_open_array(json, "cases");
    for (int i = 0; i < CASES; ++i) {
        const case_result* c = &size->cases[i];
        json_open_object(json, NULL);
        json_text(json, "name", cases[i].name);
        json_number(json, "seconds", c->seconds);
        json_numbers(json, "step_seconds", c->steps, 3);
        bench_numbers(json, {"levels", c->levels}, {"bytes", c->bytes}, {"times_stream", stream_ratio(size, i)},
                      {"times_naive", c->seconds / size->cases[NAIVE].seconds},
                      {"ns_per_pixel", 1e9 * c->seconds / pixels_of(size)});
        json_close_object(json);
    }
    json_close_array(json);
    json_close_object(json);
}

static void print_reference(const bench_session* bench, const size_result* size, double seconds) {
    const double ratio = seconds / size->cases[SCATTER_4].seconds;
    const bool full = bench->options->full;

    json_open_object(bench->json, "reference");
    bench_numbers(bench->json, {"window", WINDOW}, {"pixels", pixels_of(size)});
    json_bool(bench->json, "full", full);
    bench_numbers(bench->json, {"seconds", seconds}, {"times_scatter", ratio});
    json_close_object(bench->json);
}

/* ---- bench ---- */

/* Benches one size, optionally with the reference. */
static int bench_size(const bench_session* bench, const bench_memory* memory, const int32_t size[2], size_result* out,
                      double* reference) {
    ty_context* context = bench->session->context;
    scene s;
    ty_result result = open_scene(context, size[0], size[1], &s) ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) result = measure_size(context, &s, memory, CASES, ROUNDS_PER_RUN * bench->options->runs, out);
    if (result == TY_OK && reference != NULL) result = measure_reference(context, &s, bench->options->full, reference);
    close_scene(&s);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}

static int bench_sizes(const bench_session* bench, const bench_memory* memory) {
    const bool own = bench->options->size_given || bench->options->quick;
    const int count = own ? 1 : SIZES, reference_at = own ? 0 : 1;
    int32_t size[2];
    size_result results[SIZES];
    double reference = 0;
    int status = CLI_DONE;
    json_open_array(bench->json, "sizes");
    for (int i = 0; status == CLI_DONE && i < count; ++i) {
        bench_pixels(bench->options, sizes[i][0], sizes[i][1], size);
        status = bench_size(bench, memory, size, &results[i], i == reference_at ? &reference : NULL);
        if (status != CLI_DONE) break;
        print_size(bench->json, &results[i]);
    }
    json_close_array(bench->json);
    if (status == CLI_DONE) print_reference(bench, &results[reference_at], reference);
    return status;
}

int bench_screen(const bench_session* bench) {
    bench_memory memory;
    const int rounds_count = ROUNDS_PER_RUN * bench->options->runs;
    json_int(bench->json, "rounds", rounds_count);
    const int status =
        bench_memory_open(&memory) ? bench_sizes(bench, &memory) : cli_fail(CLI_FAILED, "not enough memory");
    bench_memory_close(&memory);
    return status;
}

/* ---- the table of a figure ---- */

ty_result bench_screen_times(ty_context* context, const int32_t size[2], int runs,
                             bench_screen_time out[BENCH_SCREEN_CASES]) {
    scene s;
    size_result measured;
    ty_result result = open_scene(context, size[0], size[1], &s) ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) result = measure_size(context, &s, NULL, TABLE_CASES, runs, &measured);
    for (int i = 0; i < TABLE_CASES && result == TY_OK; ++i) {
        out[i] = (bench_screen_time){.name = cases[i].name, .total = measured.cases[i].seconds};
        memcpy(out[i].step, measured.cases[i].steps, sizeof out[i].step);
    }
    close_scene(&s);
    return result;
}
