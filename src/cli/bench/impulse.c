/* tyndall bench impulse: making the tables, reading them from a folder, and lookups, as bakers make them: at distances
 * and angles all over the tables. One thread looks up. */
#define _GNU_SOURCE
#include "cli/bench/bench.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <tyndall/impulse.h>
#include <unistd.h>

enum { RUNS_MAX = 99, PATH_SIZE = 1024, LOOKUPS = 1 << 20, CASES = 4 };

static const struct {
    const char* name;
    ty_impulse_emitter emitter;
    int32_t bounces;
} cases[CASES] = {{"point", TY_IMPULSE_POINT, 10},
                  {"directional", TY_IMPULSE_DIRECTIONAL, 10},
                  {"area", TY_IMPULSE_AREA, 10},
                  {"area, once", TY_IMPULSE_AREA, 1}};

typedef struct measured {
    double build, load, lookup[CASES], irradiance; /* s; of one lookup */
} measured;

/* The median seconds to have tables: made, or read from the folder once they are there. */
static ty_result time_tables(const bench_session* bench, const char* folder, double* out) {
    double seconds[RUNS_MAX];
    ty_impulse_def def = ty_default_impulse_def();
    def.folder = folder;
    for (int32_t run = 0; run < bench->options->runs; ++run) {
        ty_impulse* tables = NULL;
        ty_impulse_stats stats;
        const ty_result result = ty_impulse_create(bench->session->context, &def, &tables, &stats);
        if (result != TY_OK) return result;
        ty_impulse_destroy(tables);
        seconds[run] = stats.seconds;
    }
    *out = bench_median(seconds, bench->options->runs);
    return TY_OK;
}

static double time_lookups(const bench_session* bench, const ty_impulse* tables, int which) {
    double seconds[RUNS_MAX];
    volatile float kept = 0;
    for (int32_t run = 0; run < bench->options->runs; ++run) {
        uint32_t random = 1;
        float sum = 0;
        const double start = cli_wall_seconds();
        for (int32_t i = 0; i < LOOKUPS; ++i) {
            random = random * 1664525u + 1013904223u;
            const ty_impulse_medium medium = {1, 0.9f, 0};
            ty_impulse_response response;
            ty_impulse_look(tables, cases[which].emitter, &medium, 20 * 0x1p-24f * (float)(random >> 8),
                            0x1p-12f * (float)(random & 4095), cases[which].bounces, &response);
            sum += response.single[0] + response.multiple[TY_IMPULSE_TERMS - 1];
        }
        seconds[run] = (cli_wall_seconds() - start) / LOOKUPS;
        kept = kept + sum;
    }
    return bench_median(seconds, bench->options->runs);
}

static double time_irradiance(const bench_session* bench) {
    double seconds[RUNS_MAX];
    volatile float kept = 0;
    float zonal[TY_IMPULSE_TERMS];
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) zonal[l] = 1.0f / (float)(1 + l);
    for (int32_t run = 0; run < bench->options->runs; ++run) {
        float sum = 0;
        const double start = cli_wall_seconds();
        for (int32_t i = 0; i < LOOKUPS; ++i) sum += ty_impulse_irradiance(zonal, (float)i / LOOKUPS);
        seconds[run] = (cli_wall_seconds() - start) / LOOKUPS;
        kept = kept + sum;
    }
    return bench_median(seconds, bench->options->runs);
}

static ty_result measure(const bench_session* bench, const char* folder, measured* out) {
    ty_impulse_def def = ty_default_impulse_def();
    def.folder = folder;
    ty_impulse* tables = NULL;
    ty_impulse_stats stats = {0};
    ty_result result = time_tables(bench, "", &out->build);
    if (result == TY_OK) result = ty_impulse_create(bench->session->context, &def, &tables, &stats);
    if (result == TY_OK) result = time_tables(bench, folder, &out->load);
    if (result == TY_OK) {
        for (int i = 0; i < CASES; ++i) out->lookup[i] = time_lookups(bench, tables, i);
        out->irradiance = time_irradiance(bench);
    }
    ty_impulse_destroy(tables);
    if (stats.path[0] != '\0') unlink(stats.path);
    return result;
}

static void print_measured(const bench_session* bench, const measured* m) {
    if (bench->json != NULL) {
        json_number(bench->json, "build_seconds", m->build);
        json_number(bench->json, "load_seconds", m->load);
        json_open_object(bench->json, "lookup_ns");
        for (int i = 0; i < CASES; ++i) json_number(bench->json, cases[i].name, 1e9 * m->lookup[i]);
        json_close_object(bench->json);
        json_number(bench->json, "irradiance_ns", 1e9 * m->irradiance);
        return;
    }
    printf("impulse responses, 10 bounces (medians of %d)\n  %-22s %10.2f s\n  %-22s %10.2f ms\n",
           (int)bench->options->runs, "made", m->build, "read from the folder", 1e3 * m->load);
    for (int i = 0; i < CASES; ++i)
        printf("  lookup: %-14s %10.1f ns %10.1f million/s on one thread\n", cases[i].name, 1e9 * m->lookup[i],
               1e-6 / m->lookup[i]);
    printf("  %-22s %10.1f ns\n", "irradiance", 1e9 * m->irradiance);
}

int bench_impulse(const bench_session* bench) {
    const char* place = getenv("TMPDIR");
    char folder[PATH_SIZE];
    measured m = {0};
    snprintf(folder, sizeof folder, "%s/tyndall-bench-XXXXXX", place != NULL && place[0] != '\0' ? place : "/tmp");
    if (mkdtemp(folder) == NULL)
        return cli_fail(CLI_FAILED, "%s: a folder for the bench cannot be made: %s", folder, strerror(errno));
    const ty_result result = measure(bench, folder, &m);
    rmdir(folder);
    if (result == TY_OK) print_measured(bench, &m);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
