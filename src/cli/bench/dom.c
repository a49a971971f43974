/* tyndall bench dom: solves of three channels, sweeps against optical thickness, and images beside path tracing. */
#include "cli/bench/bench.h"
#include "cli/bench/memory.h"
#include "cli/dom_scenes.h"
#include "cli/figures/figure.h"
#include "cli/ordinates_box.h"
#include "solve/ordinates/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIRECTIONS = 96, SIDES = 2, RUNS_MAX = 99 };

/* ---- what the machine could do ---- */

/* 1e9 operations and bytes a second, of all threads. */
typedef struct machine {
    double gflops, bandwidth;
} machine;

static ty_result measure_machine(const bench_session* bench, machine* out) {
    ty_context* context = bench->session->context;
    bench_memory memory;
    const bool opened = bench_memory_open(&memory);
    const int64_t threads = ty_context_threads(context);
    double bandwidth[3];
    for (int run = -1; run < 3 && opened; ++run)
        bandwidth[run < 0 ? 0 : run] = 1e-9 * bench_memory_triad(context, &memory, (bench_memory_part){0, 1}, threads);
    bench_memory_close(&memory);
    out->gflops = bench_fma_gflops(context);
    out->bandwidth = opened ? bench_median(bandwidth, 3) : 0;
    return opened && out->gflops > 0 ? TY_OK : TY_ERROR_MEMORY;
}

/* Bytes of one cell that an octant's directions read and write together: sources, moments twice, extinction. */
static double octant_bytes(int32_t bands) {
    return sizeof(float) * (3.0 * bands * bands + 1);
}

/* ---- solves ---- */

static const int32_t sides[SIDES] = {32, 64};
static const double most_ms[SIDES] = {100, 1000}; /* the bounds */

/* Smoke whose channels have extinctions and albedos of their own. */
static const char scene_text[] =
    "{\"tyndall\": 1,"
    " \"media\": [{\"name\": \"smoke\", \"bounds\": [[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]],"
    "  \"density\": {\"noise\": {\"kind\": \"cloud\", \"resolution\": 64, \"seed\": 4, \"frequency\": 4, \"octaves\": "
    "4,"
    "   \"coverage\": 0.6, \"sharpness\": 3}},"
    "  \"sigma_s\": [14, 17, 20], \"sigma_a\": [1.0, 0.6, 0.3], \"g\": 0.7}],"
    " \"lights\": [{\"type\": \"directional\", \"direction\": [-0.4, -1, -0.3], \"irradiance\": 1}]}";

/* Of a solve, medians; seconds: all, medium, uncollided light, sources, iterations, sweeps among these. */
enum { ALL, MEDIUM, DIRECT, SOURCE, SOLVE, SWEEP, PARTS };
static const char* const part_names[PARTS] = {"all", "medium", "direct", "source", "solve", "sweeps"};

typedef struct solved {
    double seconds[PARTS], cpu; /* cpu: of all processors */
    ty_dom_stats stats;         /* of the last run */
} solved;

static ty_result time_solve(const bench_session* bench, const ty_scene* scene, int32_t side, solved* out) {
    static double seconds[PARTS][RUNS_MAX], cpu[RUNS_MAX];
    const int runs = bench->options->runs;
    ty_dom_def def = ty_default_dom_def();
    def.directions = DIRECTIONS;
    def.resolution = side;
    ty_result result = TY_OK;
    for (int run = -1; run < runs && result == TY_OK; ++run) {
        ty_dom* light = NULL;
        const double begun = cli_cpu_seconds();
        result = ty_dom_solve(scene, &def, &light, &out->stats);
        cpu[run < 0 ? 0 : run] = cli_cpu_seconds() - begun;
        ty_dom_destroy(light);
        const ty_dom_stats* s = &out->stats;
        const double parts[PARTS] = {s->seconds,        s->medium_seconds, s->direct_seconds,
                                     s->source_seconds, s->solve_seconds,  s->sweep_seconds};
        for (int part = 0; part < PARTS; ++part) seconds[part][run < 0 ? 0 : run] = parts[part];
    }
    if (result != TY_OK) return result;
    for (int part = 0; part < PARTS; ++part) out->seconds[part] = bench_median(seconds[part], runs);
    out->cpu = bench_median(cpu, runs);
    return result;
}

/* Cells times directions times sweeps of all channels. */
static double swept(const ty_dom_stats* stats) {
    double sweeps = 0;
    for (int32_t plane = 0; plane < stats->planes; ++plane) sweeps += stats->sweeps[plane];
    return (double)stats->size[0] * stats->size[1] * stats->size[2] * stats->directions * sweeps;
}

static void print_solve_json(const bench_session* bench, const solved* s, double rate, double flops, double bytes,
                             const machine* peak) {
    json_writer* json = bench->json;
    json_open_object(json, NULL);
    json_numbers(json, "size", (const double[]){s->stats.size[0], s->stats.size[1], s->stats.size[2]}, 3);
    json_integer(json, "directions", s->stats.directions);
    json_integer(json, "bands", s->stats.bands);
    json_bool(json, "converged", s->stats.converged);
    json_numbers(json, "sweeps", (const double[]){s->stats.sweeps[0], s->stats.sweeps[1], s->stats.sweeps[2]}, 3);
    for (int part = 0; part < PARTS; ++part) {
        char key[32];
        snprintf(key, sizeof key, "%s_seconds", part_names[part]);
        json_number(json, key, s->seconds[part]);
    }
    json_number(json, "cpu_seconds", s->cpu);
    json_number(json, "bytes", s->stats.bytes);
    json_number(json, "cells_directions_sweeps_per_second", rate);
    json_number(json, "gflops", flops);
    json_number(json, "fraction_of_fma_peak", flops / peak->gflops);
    json_number(json, "fraction_of_bandwidth", bytes / peak->bandwidth);
    json_close_object(json);
}

static void print_solve(const bench_session* bench, int index, const solved* s, const machine* peak) {
    const double rate = swept(&s->stats) / s->seconds[SWEEP];
    const double flops = 1e-9 * rate * ty_sweep_operations(s->stats.bands);
    const double bytes = 1e-9 * rate * octant_bytes(s->stats.bands) * 8 / s->stats.directions;
    if (bench->json != NULL) {
        print_solve_json(bench, s, rate, flops, bytes, peak);
        return;
    }
    const ty_dom_stats* t = &s->stats;
    printf(
        "  %d^3: %.1f ms (at most %.0f; %.1f of all processors)%s; sweeps %d, %d, %d of %d directions, %d bands\n   ",
        (int)sides[index], 1e3 * s->seconds[ALL], most_ms[index], 1e3 * s->cpu, t->converged ? "" : ", not converged",
        (int)t->sweeps[0], (int)t->sweeps[1], (int)t->sweeps[2], (int)t->directions, (int)t->bands);
    for (int part = MEDIUM; part < PARTS; ++part) printf(" %s %.1f", part_names[part], 1e3 * s->seconds[part]);
    printf(
        "\n    %.3g cells x directions x sweeps a second: %.1f GFLOP/s, %.0f %% of the %.1f that multiply-adds reach; "
        "%.0f %% of the %.1f GB/s of memory\n",
        rate, flops, 100 * flops / peak->gflops, peak->gflops, 100 * bytes / peak->bandwidth, peak->bandwidth);
    fflush(stdout);
}

static ty_result bench_solves(const bench_session* bench) {
    machine peak = {0, 0};
    ty_scene* scene = NULL;
    ty_result result = measure_machine(bench, &peak);
    if (result == TY_OK)
        result =
            ty_scene_parse(bench->session->context, scene_text, strlen(scene_text), "bench dom", NULL, NULL, 0, &scene);
    if (bench->json != NULL)
        json_open_array(bench->json, "solves");
    else
        printf("solves of three channels, to 1e-3 (ms, medians of %d)\n", (int)bench->options->runs);
    for (int i = 0; i < SIDES && result == TY_OK; ++i) {
        solved s;
        result = time_solve(bench, scene, sides[i], &s);
        if (result == TY_OK) print_solve(bench, i, &s, &peak);
    }
    if (bench->json != NULL) json_close_array(bench->json);
    ty_scene_destroy(scene);
    return result;
}

/* ---- sweeps against thickness ---- */

enum { EDGE = 32, THICKNESSES = 5, SWEEPS = 400 };

/* Sweeps and milliseconds of one solve, or that it takes too many. */
static void print_sweeps(const bench_session* bench, const char* key, const ty_ordinates_stats* stats) {
    if (bench->json != NULL) {
        json_open_object(bench->json, key);
        json_bool(bench->json, "converged", stats->converged);
        json_integer(bench->json, "sweeps", stats->sweeps);
        json_integer(bench->json, "cycles", stats->cycles);
        json_number(bench->json, "seconds", stats->seconds);
        json_close_object(bench->json);
    } else {
        printf(" %12s%4d %9.1f", stats->converged ? "" : "not after", (int)stats->sweeps, 1e3 * stats->seconds);
    }
}

/* skips: source iteration is known to take too long. */
static ty_result time_thickness(const bench_session* bench, ordinates_box_kind kind, double thickness, bool* skips) {
    static const char* const keys[2] = {"diffusion", "none"};
    ordinates_box box;
    ty_result result = ordinates_box_open(bench->session->context, kind, EDGE, DIRECTIONS, thickness, &box);
    if (result != TY_OK) return result;
    if (bench->json != NULL) {
        json_open_object(bench->json, NULL);
        json_text(bench->json, "medium", ordinates_box_names[kind]);
        json_number(bench->json, "thickness", thickness);
    } else {
        printf("  %-6s %8g", ordinates_box_names[kind], thickness);
    }
    for (int plain = 0; plain < (*skips ? 1 : 2) && result == TY_OK; ++plain) {
        ty_ordinates_stats stats;
        box.def.accelerated = plain == 0;
        box.def.sweeps = SWEEPS;
        result = ordinates_box_solve(bench->session->context, &box, NULL, 0, &stats);
        if (result == TY_OK) print_sweeps(bench, keys[plain], &stats);
        if (result == TY_OK && plain == 1) *skips = !stats.converged;
    }
    ordinates_box_close(&box);
    if (bench->json != NULL)
        json_close_object(bench->json);
    else
        printf("\n");
    fflush(stdout);
    return result;
}

static ty_result bench_thickness(const bench_session* bench) {
    ty_result result = TY_OK;
    if (bench->json != NULL)
        json_open_array(bench->json, "thickness");
    else
        printf("sweeps until 1e-3 is to come, %d^3 cells, %d directions, one channel\n  %-6s %8s %16s %9s %16s %9s\n",
               EDGE, DIRECTIONS, "medium", "optical", "with diffusion", "ms", "without", "ms");
    for (int kind = 0; kind < ORDINATES_BOX_KINDS && result == TY_OK; ++kind) {
        bool skips = false;
        for (int i = 0; i < THICKNESSES && result == TY_OK; ++i)
            result = time_thickness(bench, (ordinates_box_kind)kind, pow(10, i), &skips);
    }
    if (bench->json != NULL) json_close_array(bench->json);
    return result;
}

/* ---- images ---- */

enum { WIDTH = 384, HEIGHT = 216, BLOCKS = 2 };

static const int32_t blocks[BLOCKS] = {1, 4};
/* Images of one scene, small enough for path tracing, and how long they took; the same by dom as large as the scene's
 * camera has it. */
typedef struct pair {
    ty_image *truth, *image;
    ty_path_stats path;
    ty_dom_stats dom, whole;
    double path_cpu, whole_cpu; /* s of all processors */
    double larger;              /* pixels of the whole image over those of the small one */
} pair;

static void free_pair(pair* p) {
    ty_image_destroy(p->truth);
    ty_image_destroy(p->image);
}

static ty_result load_cloud(const bench_session* bench, const char** name, ty_scene** out) {
    const char* data = bench->options->data;
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", data != NULL ? data : "", dom_disney_file);
    FILE* file = data != NULL ? fopen(path, "rb") : NULL;
    *name = file != NULL ? "Disney cloud" : "builtin:cloud_sun";
    if (file == NULL) return ty_scene_load(bench->session->context, *name, NULL, 0, out);
    fclose(file);
    return ty_scene_parse(bench->session->context, dom_disney_scene, strlen(dom_disney_scene), "disney", data, NULL, 0,
                          out);
}

static ty_result render_pair(const bench_session* bench, const ty_scene* scene, pair* out) {
    int32_t size[2];
    const ty_camera_def camera = ty_scene_camera(scene);
    ty_image* large = NULL;
    ty_path_def path = ty_default_path_def();
    ty_dom_def dom = ty_default_dom_def();
    double cpu = cli_cpu_seconds();
    ty_result result = ty_dom_render(scene, &dom, &large, &out->whole);
    ty_image_destroy(large);
    out->whole_cpu = cli_cpu_seconds() - cpu;
    path.spp = bench->options->spp;
    bench_pixels(bench->options, WIDTH, HEIGHT, size);
    path.width = dom.width = size[0];
    path.height = dom.height = size[1];
    path.aovs = TY_AOV_VARIANCE;
    path.progress = cli_progress_report;
    path.progress_user = &bench->session->progress;
    out->larger = (double)camera.resolution[0] * camera.resolution[1] / ((double)path.width * path.height);
    if (result == TY_OK) result = ty_dom_render(scene, &dom, &out->image, &out->dom);
    cpu = cli_cpu_seconds();
    if (result == TY_OK) result = ty_path_render(scene, &path, &out->truth, &out->path);
    out->path_cpu = cli_cpu_seconds() - cpu;
    cli_progress_clear(&bench->session->progress);
    return result;
}

/* What path tracing would take for the error that the image has, of means over blocks of pixels: its noise falls with
 * the root of its time. The truth's own noise is taken out of the error; NaN: that is all there is. */
typedef struct equal_error {
    double mean_ratio, error, noise;
    double more;      /* samples per pixel, times those that were taken */
    double faster[2]; /* path's time over dom's, of the whole image: on the clock, of all processors */
} equal_error;

static ty_result find_equal(const bench_session* bench, const pair* p, int32_t block, equal_error* out) {
    ty_difference difference;
    double noise[4];
    const ty_result result = ty_image_compare(bench->session->context, p->image, p->truth, block, &difference);
    if (result != TY_OK) return result;
    figure_noise(p->truth, block, noise);
    const double mean = difference.rmse[3] / difference.relative_rmse[3];
    out->mean_ratio = difference.mean_ratio[3];
    out->error = figure_without_noise(difference.rmse[3], noise[3]) / mean;
    out->noise = noise[3] / mean;
    out->more = pow(out->noise / out->error, 2);
    out->faster[0] = out->more * p->larger * p->path.seconds / p->whole.seconds;
    out->faster[1] = out->more * p->larger * p->path_cpu / p->whole_cpu;
    return TY_OK;
}

static void print_equal(const bench_session* bench, const pair* p, int32_t block, const equal_error* e) {
    if (bench->json != NULL) {
        json_open_object(bench->json, NULL);
        json_integer(bench->json, "block", block);
        json_number(bench->json, "mean_ratio", e->mean_ratio);
        json_number(bench->json, "path_noise", e->noise);
        if (!isnan(e->error)) {
            json_number(bench->json, "relative_rmse", e->error);
            json_number(bench->json, "path_spp_at_equal_error", e->more * p->path.spp);
            json_number(bench->json, "path_over_dom", e->faster[0]);
            json_number(bench->json, "path_over_dom_cpu", e->faster[1]);
        }
        json_close_object(bench->json);
        return;
    }
    printf("  means over %d x %d pixels: mean ratio %.3f, path's noise %.4f; ", (int)block, (int)block, e->mean_ratio,
           e->noise);
    if (isnan(e->error))
        printf("dom's error is less than can be told from it\n");
    else
        printf("relative RMSE %.4f, for which path takes %.0f spp and %.0f times as long (at least 100; %.0f times the "
               "processors' time)\n",
               e->error, e->more * p->path.spp, e->faster[0], e->faster[1]);
}

static void print_pair(const bench_session* bench, const char* name, const ty_scene* scene, const pair* p) {
    const ty_dom_stats* dom = &p->whole;
    const ty_camera_def camera = ty_scene_camera(scene);
    const int32_t* whole = camera.resolution;
    if (bench->json != NULL) {
        json_text(bench->json, "scene", name);
        json_numbers(bench->json, "size", (const double[]){whole[0], whole[1]}, 2);
        json_number(bench->json, "dom_seconds", dom->seconds);
        json_number(bench->json, "dom_before_march_seconds", dom->seconds - dom->march_seconds);
        json_number(bench->json, "path_seconds", p->larger * p->path.seconds);
        json_number(bench->json, "path_spp", p->path.spp);
        return;
    }
    printf("%s, %dx%d: dom %.3f s (medium %.3f, direct %.3f, sources %.3f, solve %.3f, march %.3f), path at %g spp, "
           "from %dx%d, %.1f s\n",
           name, (int)whole[0], (int)whole[1], dom->seconds, dom->medium_seconds, dom->direct_seconds,
           dom->source_seconds, dom->solve_seconds, dom->march_seconds, p->path.spp, (int)ty_image_width(p->image),
           (int)ty_image_height(p->image), p->larger * p->path.seconds);
}

static ty_result bench_images(const bench_session* bench) {
    const char* name = "";
    ty_scene* scene = NULL;
    pair p = {0};
    if (bench->json != NULL) json_open_object(bench->json, "image");
    ty_result result = load_cloud(bench, &name, &scene);
    if (result == TY_OK) result = render_pair(bench, scene, &p);
    if (result == TY_OK) print_pair(bench, name, scene, &p);
    if (bench->json != NULL) json_open_array(bench->json, "equal_error");
    for (int i = 0; i < BLOCKS && result == TY_OK; ++i) {
        equal_error equal;
        result = find_equal(bench, &p, blocks[i], &equal);
        if (result == TY_OK) print_equal(bench, &p, blocks[i], &equal);
    }
    if (bench->json != NULL) {
        json_close_array(bench->json);
        json_close_object(bench->json);
    }
    free_pair(&p);
    ty_scene_destroy(scene);
    return result;
}

int bench_dom(const bench_session* bench) {
    ty_result result = bench_solves(bench);
    if (result == TY_OK) result = bench_thickness(bench);
    if (result == TY_OK) result = bench_images(bench);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
