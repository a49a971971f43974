/* tyndall bench: the table of benches and the options they share. */
#include "cli/bench.h"
#include "cli/commands.h"

#include <stdlib.h>
#include <string.h>

typedef struct bench_entry {
    const char* name;
    const char* summary;
    int (*run)(const bench_session* bench);
} bench_entry;

static const bench_entry benches[] = {
    {"machine", "peak arithmetic and memory bandwidth of this machine", bench_machine},
    {"path", "noise, time and samples per second of the path tracer over scenes", bench_path},
    {"direct", "light that has not scattered yet, on grids: cells per second", bench_direct},
    {"rays", "rays per second through a mesh, beside a bare loop over Embree", bench_rays},
    {"screen", "screen-space scattering, beside streaming its bytes and its reference", bench_screen},
    {"fld", "flux-limited diffusion: its solvers, and images beside path", bench_fld},
    {"pop", "principal-ordinates propagation: its stages, and how they grow", bench_pop},
    {"lpv", "light propagation volumes: stages as in the paper's Table 1, growth, a frame", bench_lpv},
    {"dom", "discrete ordinates: solves, sweeps against thickness, images beside path", bench_dom},
    {"impulse", "tables of impulse responses: making, reading, looking up", bench_impulse},
    {"bake", "baking: what impulse responses cost, and save beside paths", bench_bake},
    {"load", "reading volumes of every format", bench_load},
};
enum { BENCH_COUNT = sizeof benches / sizeof benches[0] };

static int compare_numbers(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

double bench_median(double* values, int count) {
    qsort(values, (size_t)count, sizeof *values, compare_numbers);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

static int unknown_bench(const char* name) {
    const char* names[BENCH_COUNT + 1];
    char list[256] = "";
    for (int i = 0; i < BENCH_COUNT; ++i) {
        names[i] = benches[i].name;
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s, ", names[i]);
    }
    names[BENCH_COUNT] = "all";
    const char* nearest = cli_nearest(name, names, BENCH_COUNT + 1);
    if (nearest != NULL)
        return cli_usage_error("bench", "unknown bench '%s'; did you mean '%s'? There are: %sall", name, nearest, list);
    return cli_usage_error("bench", "unknown bench '%s'; there are: %sall", name, list);
}

static int run_benches(cli_session* session, const bench_options* options, const char* name) {
    json_writer writer = json_begin(stdout);
    bench_session bench = {session, options, options->json ? &writer : NULL};
    int status = CLI_DONE;
    if (bench.json != NULL) {
        json_open_object(bench.json, NULL);
        json_text(bench.json, "version", ty_version());
        json_integer(bench.json, "threads", ty_context_threads(session->context));
    }
    for (int i = 0; status == CLI_DONE && i < BENCH_COUNT; ++i) {
        if (strcmp(name, "all") != 0 && strcmp(name, benches[i].name) != 0) continue;
        if (bench.json != NULL) json_open_object(bench.json, benches[i].name);
        status = benches[i].run(&bench);
        if (bench.json != NULL) json_close_object(bench.json);
    }
    if (bench.json != NULL) json_close_object(bench.json);
    return status;
}

static bool is_bench(const char* name) {
    for (int i = 0; i < BENCH_COUNT; ++i)
        if (strcmp(name, benches[i].name) == 0) return true;
    return strcmp(name, "all") == 0;
}

int cli_bench(int count, char** arguments) {
    bench_options options = {.spp = 64,
                             .size = {256, 256},
                             .runs = 3,
                             .side = 192,
                             .data = getenv("TYNDALL_DATA"),
                             .scenes = "cube_g0,cube_g0.7,cube_g0.96,cornell_fog,lamps,cloud_sun,cloud_sky"};
    const cli_option table[] = {
        {"json", 0, CLI_FLAG, NULL, "print JSON", &options.json, 0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "samples per pixel (default 64)", &options.spp, 1, 1 << 24, NULL},
        {"size", 0, CLI_SIZE, "WxH",
         "pixels (default 256x256; rays: 1024x1024; screen: 1, 2, 4 and 8 million; "
         "fld, pop: 1024x1024; lpv: 1280x720; dom: 384x216; bake: 48x48 receivers)",
         options.size, 0, 0, &options.size_given},
        {"runs", 0, CLI_INT, "N", "repetitions whose median counts (default 3)", &options.runs, 1, 99, NULL},
        {"side", 0, CLI_INT, "N", "voxels a side of the volumes to load (default 192)", &options.side, 8, 1024, NULL},
        {"scenes", 0, CLI_TEXT, "A,B,...", "scenes to render: files, or names of builtin ones", &options.scenes, 0, 0,
         NULL},
        {"full", 0, CLI_FLAG, NULL, "screen: the whole image through the reference, not 100 rows", &options.full, 0, 0,
         NULL},
        {"mesh", 0, CLI_TEXT, "FILE", "mesh for the rays (default: a terrain)", &options.mesh, 0, 0, NULL},
        {"reference", 0, CLI_TEXT, "DIR", "also compare with DIR/SCENE.exr", &options.reference, 0, 0, NULL},
        {"data", 0, CLI_TEXT, "DIR", "lpv, dom: third-party scenes (default: the environment variable TYNDALL_DATA)",
         &options.data, 0, 0, NULL},
    };
    char details[1024] = "benches:";
    for (int i = 0; i < BENCH_COUNT; ++i) {
        const size_t used = strlen(details);
        snprintf(details + used, sizeof details - used, "\n  %-10s %s", benches[i].name, benches[i].summary);
    }
    const cli_syntax syntax = {"bench",
                               "NAME|all [options]",
                               "Measures speed on this machine.",
                               details,
                               table,
                               sizeof table / sizeof table[0],
                               1,
                               1};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO && !is_bench(given.positional[0])) status = unknown_bench(given.positional[0]);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "bench", &given.common);
    if (status != CLI_GO) return status;
    return cli_session_close(&session, run_benches(&session, &options, given.positional[0]));
}
