/* tyndall bench dom: solves of three channels, number of sweeps over optical thickness, and images compared with path
 * tracing. */
#include "bench/bench.h"
#include "bench/memory.h"
#include "bench/milk.h"
#include "bench/noise.h"
#include "bench/ordinates_box.h"
#include "method/registry.h"
#include "scenes/scenes.h"
#include "solve/ordinates/sweep.h"

#include <math.h>
#include <string.h>

enum { DIRECTIONS = 96, SIDES = 2, RUNS_MAX = 99 };

/* ---- peak performance of the machine ---- */

/* 1e9 operations and bytes per second, all threads. */
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
        bandwidth[run < 0 ? 0 : run] = 1e-9 * bench_memory_triad(context, &memory, (bench_memory_slice){0, 1}, threads);
    bench_memory_close(&memory);
    out->gflops = bench_fma_gflops(context);
    out->bandwidth = opened ? bench_median(bandwidth, 3) : 0;
    return opened && out->gflops > 0 ? TY_OK : TY_ERROR_MEMORY;
}

/* Bytes read and written per cell by the ordinates of an octant together: source moments, flux moments twice,
 * extinction. */
static double octant_bytes(int32_t bands) {
    return sizeof(float) * (3.0 * bands * bands + 1);
}

/* ---- solves ---- */

static const int32_t sides[SIDES] = {32, 64};
static const double max_ms[SIDES] = {100, 1000}; /* aims */

/* Smoke with different extinctions and albedos per channel. */
/* Medians of a solve; seconds: total, medium, uncollided light, sources, iterations, sweeps within iterations. */
enum { ALL, MEDIUM, DIRECT, SOURCE, SOLVE, SWEEP, PARTS };
static const char* const part_names[PARTS] = {"all", "medium", "direct", "source", "solve", "sweeps"};

typedef struct solved {
    double seconds[PARTS], cpu; /* cpu: CPU seconds of all threads */
    ty_dom_stats stats;         /* of the last run */
} solved;

static ty_result time_solve(const bench_session* bench, const ty_scene* scene, int32_t side, solved* out) {
    static double seconds[PARTS][RUNS_MAX], cpu[RUNS_MAX];
    const int runs = bench->options->runs;
    ty_dom_def def = ty_default_dom_def();
    def.directions = DIRECTIONS;
    def.resolution = side;
    ty_result result = TY_OK;
    out->stats = ty_default_dom_stats();
    for (int run = -1; run < runs && result == TY_OK; ++run) {
        ty_dom* light = NULL;
        const double begun = cli_cpu_seconds();
        result = ty_dom_solve(scene, &def, &light, &out->stats);
        cpu[run < 0 ? 0 : run] = cli_cpu_seconds() - begun;
        ty_dom_destroy(light);
        const ty_dom_stats* s = &out->stats;
        const double parts[PARTS] = {s->seconds,        s->medium_seconds, s->direct_seconds,
                                     s->source_seconds, s->solve_seconds,  s->sweep_seconds};
        for (int stage = 0; stage < PARTS; ++stage) seconds[stage][run < 0 ? 0 : run] = parts[stage];
    }
    if (result != TY_OK) return result;
    for (int stage = 0; stage < PARTS; ++stage) out->seconds[stage] = bench_median(seconds[stage], runs);
    out->cpu = bench_median(cpu, runs);
    return result;
}

/* Unknowns: cells times ordinates times sweeps, over all channels. */
static double swept(const ty_dom_stats* stats) {
    double sweeps = 0;
    for (int32_t plane = 0; plane < stats->planes; ++plane) sweeps += stats->sweeps[plane];
    return (double)stats->size[0] * stats->size[1] * stats->size[2] * stats->directions * sweeps;
}

static void print_solve_json(const bench_session* bench, int index, const solved* s, double rate, double flops,
                             double bytes, const machine* peak) {
    json_writer* json = bench->json;
    json_open_object(json, NULL);
    json_numbers(json, "size", (const double[]){s->stats.size[0], s->stats.size[1], s->stats.size[2]}, 3);
    bench_numbers(json, {"directions", s->stats.directions}, {"bands", s->stats.bands});
    json_bool(json, "converged", s->stats.converged);
    json_numbers(json, "sweeps", (const double[]){s->stats.sweeps[0], s->stats.sweeps[1], s->stats.sweeps[2]}, 3);
    for (int stage = 0; stage < PARTS; ++stage) {
        char key[32];
        snprintf(key, sizeof key, "%s_seconds", part_names[stage]);
        json_number(json, key, s->seconds[stage]);
    }
    bench_numbers(json, {"cpu_seconds", s->cpu}, {"aim_ms", max_ms[index]}, {"bytes", s->stats.memory_bytes},
                  {"cells_directions_sweeps_per_second", rate}, {"gflops", flops},
                  {"fraction_of_fma_peak", flops / peak->gflops}, {"fraction_of_bandwidth", bytes / peak->bandwidth});
    json_close_object(json);
}

static void print_solve(const bench_session* bench, int index, const solved* s, const machine* peak) {
    const double rate = swept(&s->stats) / s->seconds[SWEEP];
    const double flops = 1e-9 * rate * ty_sweep_operations(s->stats.bands);
    const double bytes = 1e-9 * rate * octant_bytes(s->stats.bands) * 8 / s->stats.directions;
    print_solve_json(bench, index, s, rate, flops, bytes, peak);
}

static ty_result bench_solves(const bench_session* bench) {
    machine peak = {0, 0};
    ty_scene* scene = NULL;
    ty_result result = measure_machine(bench, &peak);
    if (result == TY_OK)
        result = tools_load_scene(bench->session->context, "bench_colored_smoke", NULL, NULL, 0, &scene);
    json_open_array(bench->json, "solves");
    for (int i = 0; i < SIDES && result == TY_OK; ++i) {
        solved s;
        result = time_solve(bench, scene, sides[i], &s);
        if (result == TY_OK) print_solve(bench, i, &s, &peak);
    }
    json_close_array(bench->json);
    ty_scene_destroy(scene);
    return result;
}

/* ---- sweeps against thickness ---- */

enum { EDGE = 32, THICKNESSES = 5, SWEEPS = 400 };

/* Prints sweeps and milliseconds of one solve, or that the limit of sweeps is exceeded. */
static void print_sweeps(const bench_session* bench, const char* key, const ty_ordinates_stats* stats) {
    json_open_object(bench->json, key);
    json_bool(bench->json, "converged", stats->converged);
    bench_numbers(bench->json, {"sweeps", stats->sweeps}, {"cycles", stats->cycles}, {"seconds", stats->seconds});
    json_close_object(bench->json);
}

/* skips: source iteration is known to exceed the limit. */
static ty_result time_thickness(const bench_session* bench, ordinates_box_kind kind, double thickness, bool* skips) {
    static const char* const keys[2] = {"diffusion", "none"};
    ordinates_box box;
    ty_result result = ordinates_box_open(bench->session->context, kind, EDGE, DIRECTIONS, thickness, &box);
    if (result != TY_OK) return result;
    json_open_object(bench->json, NULL);
    json_text(bench->json, "medium", ordinates_box_names[kind]);
    json_number(bench->json, "thickness", thickness);
    for (int plain = 0; plain < (*skips ? 1 : 2) && result == TY_OK; ++plain) {
        ty_ordinates_stats stats;
        box.def.accelerated = plain == 0;
        box.def.sweeps = SWEEPS;
        result = ordinates_box_solve(bench->session->context, &box, NULL, 0, &stats);
        if (result == TY_OK) print_sweeps(bench, keys[plain], &stats);
        if (result == TY_OK && plain == 1) *skips = !stats.converged;
    }
    ordinates_box_close(&box);
    json_close_object(bench->json);
    return result;
}

static ty_result bench_thickness(const bench_session* bench) {
    ty_result result = TY_OK;
    json_open_array(bench->json, "thickness");
    for (int kind = 0; kind < ORDINATES_BOX_KINDS && result == TY_OK; ++kind) {
        bool skips = false;
        for (int i = 0; i < THICKNESSES && result == TY_OK; ++i)
            result = time_thickness(bench, (ordinates_box_kind)kind, pow(10, i), &skips);
    }
    json_close_array(bench->json);
    return result;
}

/* ---- images ---- */

enum { WIDTH = 384, HEIGHT = 216, BLOCKS = 2 };

static const int32_t blocks[BLOCKS] = {1, 4};
/* Images of one scene in a size small enough for path tracing, with their times, and the time of dom at the camera's
 * full resolution. */
typedef struct pair {
    ty_image *truth, *image;
    ty_path_stats path;
    ty_dom_stats dom, full;
    double path_cpu, full_cpu; /* CPU seconds of all threads */
    double larger;             /* pixels of the full image over those of the small one */
} pair;

static void free_pair(pair* p) {
    ty_image_destroy(p->truth);
    ty_image_destroy(p->image);
}

static ty_result load_cloud(const bench_session* bench, const char** name, ty_scene** out) {
    const char* data = bench->options->data;
    const bool found = tools_has_data(data, DISNEY_CLOUD_FILE);
    *name = found ? "Disney cloud" : "builtin:cloud_sun";
    return tools_load_scene(bench->session->context, found ? "dom_disney_cloud" : *name, data, NULL, 0, out);
}

static ty_result render_pair(const bench_session* bench, const ty_scene* scene, pair* out) {
    int32_t size[2];
    const ty_camera_def camera = ty_scene_camera(scene);
    ty_image* large = NULL;
    ty_path_def path = ty_default_path_def();
    ty_dom_def dom = ty_default_dom_def();
    double cpu = cli_cpu_seconds();
    out->dom = out->full = ty_default_dom_stats();
    out->path = ty_default_path_stats();
    ty_result result = ty_dom_render(scene, &dom, &large, &out->full);
    ty_image_destroy(large);
    out->full_cpu = cli_cpu_seconds() - cpu;
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

/* Path tracing at equal error of means over blocks of pixels: its noise falls with the square root of its time. The
 * error is corrected for the reference's noise; NaN: the error is below the noise. */
typedef struct equal_error {
    double mean_ratio, error, noise;
    double more;      /* samples per pixel at equal error over those of the reference */
    double faster[2]; /* path's time over dom's for the full image: wall time, CPU time */
} equal_error;

static ty_result find_equal(const bench_session* bench, const pair* p, int32_t block, equal_error* out) {
    ty_difference difference;
    double noise[4];
    const ty_result result = ty_image_compare(bench->session->context, p->image, p->truth, block, &difference);
    if (result != TY_OK) return result;
    bench_noise(p->truth, block, noise);
    const double mean = difference.rmse[3] / difference.relative_rmse[3];
    out->mean_ratio = difference.mean_ratio[3];
    out->error = bench_without_noise(difference.rmse[3], noise[3]) / mean;
    out->noise = noise[3] / mean;
    out->more = pow(out->noise / out->error, 2);
    out->faster[0] = out->more * p->larger * p->path.seconds / p->full.seconds;
    out->faster[1] = out->more * p->larger * p->path_cpu / p->full_cpu;
    return TY_OK;
}

static void print_equal(const bench_session* bench, const pair* p, int32_t block, const equal_error* e) {
    json_open_object(bench->json, NULL);
    bench_numbers(bench->json, {"block", block}, {"mean_ratio", e->mean_ratio}, {"path_noise", e->noise});
    if (!isnan(e->error)) {
        bench_numbers(bench->json, {"relative_rmse", e->error}, {"path_spp_at_equal_error", e->more * p->path.spp},
                      {"path_over_dom", e->faster[0]}, {"path_over_dom_cpu", e->faster[1]});
    }
    json_close_object(bench->json);
}

static void print_pair(const bench_session* bench, const char* name, const ty_scene* scene, const pair* p) {
    const ty_dom_stats* dom = &p->full;
    const ty_camera_def camera = ty_scene_camera(scene);
    const int32_t* full = camera.resolution;
    json_text(bench->json, "scene", name);
    json_numbers(bench->json, "size", (const double[]){full[0], full[1]}, 2);
    bench_numbers(bench->json, {"dom_seconds", dom->seconds},
                  {"dom_before_march_seconds", dom->seconds - dom->march_seconds},
                  {"path_seconds", p->larger * p->path.seconds}, {"path_spp", p->path.spp});
}

static ty_result bench_images(const bench_session* bench) {
    const char* name = "";
    ty_scene* scene = NULL;
    pair p = {0};
    json_open_object(bench->json, "image");
    ty_result result = load_cloud(bench, &name, &scene);
    if (result == TY_OK) result = render_pair(bench, scene, &p);
    if (result == TY_OK) print_pair(bench, name, scene, &p);
    json_open_array(bench->json, "equal_error");
    for (int i = 0; i < BLOCKS && result == TY_OK; ++i) {
        equal_error equal;
        result = find_equal(bench, &p, blocks[i], &equal);
        if (result == TY_OK) print_equal(bench, &p, blocks[i], &equal);
    }
    json_close_array(bench->json);
    json_close_object(bench->json);
    free_pair(&p);
    ty_scene_destroy(scene);
    return result;
}

int bench_dom(const bench_session* bench) {
    ty_result result = bench_solves(bench);
    if (result == TY_OK) result = bench_thickness(bench);
    if (result == TY_OK) result = bench_images(bench);
    if (result == TY_OK) result = bench_milk(bench, &ty_method_dom);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
