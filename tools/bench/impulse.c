/* tyndall bench impulse: computing the tables, reading them from a folder, and lookups at distances and angles over the
 * whole table: general ones, as for heterogeneous media, and merged ones, as for a medium of uniform albedo and g.
 * Lookups run on one thread. */
#define _GNU_SOURCE
#include "bench/bench.h"
#include "method/impulse/lookup.h"

#include <float.h>
#include <stdlib.h>
#include <tyndall/impulse.h>
#include <unistd.h>

enum { RUNS_MAX = 99, LOOKUPS = 1 << 20, CASES = 6, BOUNCES = 10 };

static const struct {
    const char* name;
    ty_impulse_emitter emitter;
    int32_t bounces;
    bool merged;
} cases[CASES] = {
    {"point", TY_IMPULSE_POINT, BOUNCES, false},        {"directional", TY_IMPULSE_DIRECTIONAL, BOUNCES, false},
    {"area", TY_IMPULSE_AREA, BOUNCES, false},          {"area, once", TY_IMPULSE_AREA, 1, false},
    {"point, merged", TY_IMPULSE_POINT, BOUNCES, true}, {"area, merged", TY_IMPULSE_AREA, BOUNCES, true}};

static const ty_impulse_medium medium = {1, 0.9f, 0};

typedef struct measured {
    double build, load, lookup[CASES], irradiance; /* seconds; lookups: of one lookup */
} measured;

/* The median seconds to obtain tables: computed, or read from the folder once present. */
static ty_result time_tables(const bench_session* bench, const char* folder, double* out) {
    double seconds[RUNS_MAX];
    ty_impulse_def def = ty_default_impulse_def();
    def.folder = folder;
    for (int32_t run = 0; run < bench->options->runs; ++run) {
        ty_impulse* tables = NULL;
        ty_impulse_stats stats = ty_default_impulse_stats();
        const ty_result result = ty_impulse_create(bench->session->context, &def, &tables, &stats);
        if (result != TY_OK) return result;
        ty_impulse_destroy(tables);
        seconds[run] = stats.seconds;
    }
    *out = bench_median(seconds, bench->options->runs);
    return TY_OK;
}

static double time_lookups(const bench_session* bench, const ty_impulse* tables, const ty_impulse_merged* merged,
                           int which) {
    double seconds[RUNS_MAX];
    volatile float checksum = 0;
    for (int32_t run = 0; run < bench->options->runs; ++run) {
        uint32_t random = 1;
        float sum = 0;
        const double start = cli_wall_seconds();
        for (int32_t i = 0; i < LOOKUPS; ++i) {
            random = random * 1664525u + 1013904223u;
            const float distance = 20 * 0x1p-24f * (float)(random >> 8), cosine = 0x1p-12f * (float)(random & 4095);
            ty_impulse_response response;
            if (cases[which].merged)
                ty_impulse_lookup_merged(merged, (int32_t)cases[which].emitter, medium.sigma_t, distance, cosine,
                                         &response);
            else
                ty_impulse_look(tables, cases[which].emitter, &medium, distance, cosine, cases[which].bounces,
                                &response);
            sum += response.single[0] + response.multiple[TY_IMPULSE_TERMS - 1];
        }
        seconds[run] = (cli_wall_seconds() - start) / LOOKUPS;
        checksum = checksum + sum;
    }
    return bench_median(seconds, bench->options->runs);
}

static ty_result time_all_lookups(const bench_session* bench, const ty_impulse* tables, double seconds[CASES]) {
    ty_impulse_sum* rows = malloc(ty_impulse_merged_rows() * sizeof *rows);
    if (rows == NULL) return TY_ERROR_MEMORY;
    ty_impulse_merged merged;
    ty_impulse_merge(tables, medium.sigma_s / medium.sigma_t, medium.g, BOUNCES, FLT_MAX, rows, &merged);
    for (int i = 0; i < CASES; ++i) seconds[i] = time_lookups(bench, tables, &merged, i);
    free(rows);
    return TY_OK;
}

static double time_irradiance(const bench_session* bench) {
    double seconds[RUNS_MAX];
    volatile float checksum = 0;
    float zonal[TY_IMPULSE_TERMS];
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) zonal[l] = 1.0f / (float)(1 + l);
    for (int32_t run = 0; run < bench->options->runs; ++run) {
        float sum = 0;
        const double start = cli_wall_seconds();
        for (int32_t i = 0; i < LOOKUPS; ++i) sum += ty_impulse_irradiance(zonal, (float)i / LOOKUPS);
        seconds[run] = (cli_wall_seconds() - start) / LOOKUPS;
        checksum = checksum + sum;
    }
    return bench_median(seconds, bench->options->runs);
}

static ty_result measure(const bench_session* bench, const char* folder, measured* out) {
    ty_impulse_def def = ty_default_impulse_def();
    def.folder = folder;
    ty_impulse* tables = NULL;
    ty_impulse_stats stats = ty_default_impulse_stats();
    ty_result result = time_tables(bench, "", &out->build);
    if (result == TY_OK) result = ty_impulse_create(bench->session->context, &def, &tables, &stats);
    if (result == TY_OK) result = time_tables(bench, folder, &out->load);
    if (result == TY_OK) result = time_all_lookups(bench, tables, out->lookup);
    if (result == TY_OK) out->irradiance = time_irradiance(bench);
    ty_impulse_destroy(tables);
    if (stats.path[0] != '\0') unlink(stats.path);
    return result;
}

static void print_measured(const bench_session* bench, const measured* m) {
    bench_numbers(bench->json, {"build_seconds", m->build}, {"load_seconds", m->load});
    json_open_object(bench->json, "lookup_ns");
    for (int i = 0; i < CASES; ++i) json_number(bench->json, cases[i].name, 1e9 * m->lookup[i]);
    json_close_object(bench->json);
    json_number(bench->json, "irradiance_ns", 1e9 * m->irradiance);
}

int bench_impulse(const bench_session* bench) {
    char folder[BENCH_PATH_SIZE];
    measured m = {0};
    if (bench_make_folder(folder) != CLI_GO) return CLI_FAILED;
    const ty_result result = measure(bench, folder, &m);
    rmdir(folder);
    if (result == TY_OK) print_measured(bench, &m);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
