/* Running benches. */
#define _GNU_SOURCE
#include "bench/run.h"
#include "cli/text/text_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* ---- other load ---- */

/* Busy seconds of all processors since boot; NaN: unknown. */
static double busy_seconds(void) {
    unsigned long long user, nice, system;
    FILE* file = fopen("/proc/stat", "r");
    if (file == NULL) return NAN;
    const bool read = fscanf(file, "cpu %llu %llu %llu", &user, &nice, &system) == 3;
    fclose(file);
    return read ? (double)(user + nice + system) / (double)sysconf(_SC_CLK_TCK) : NAN;
}

static double load_average(void) {
    double load;
    return getloadavg(&load, 1) == 1 ? load : NAN;
}

/* ---- one bench ---- */

/* The measurements of one bench so far. */
typedef struct bench_state {
    int status;                       /* CLI_GO: it did not run */
    char message[512];                /* the reason of a failure */
    double load_before;               /* one-minute load average before the first round */
    double others_busy, seconds;      /* of a round: processors busy with other programs; seconds */
    json_t* rounds[BENCH_ROUNDS_MAX]; /* output */
    int count;
} bench_state;

/* Output is buffered in memory, so that a failed bench leaves no partial output. */
static int run_into_memory(cli_session* session, const bench_options* options, const bench_entry* entry,
                           bench_state* state) {
    cli_text memory;
    if (!cli_text_open(&memory)) return cli_fail(CLI_FAILED, "not enough memory");
    json_writer writer = json_begin(memory.file);
    const bench_session bench = {session, options, &writer};
    json_open_object(&writer, NULL);
    int status = entry->run(&bench);
    if (status == CLI_DONE) json_close_object(&writer);
    char* text = cli_text_close(&memory);
    if (status == CLI_DONE) {
        state->rounds[state->count] = text == NULL ? NULL : json_loadb(text, memory.size, 0, NULL);
        if (state->rounds[state->count++] == NULL) status = cli_fail(CLI_FAILED, "not enough memory");
    }
    free(text);
    return status;
}

/* The mean over rounds, the last of which has this value. */
static double add_to_mean(double mean, double value, int count) {
    return count == 1 ? value : mean + (value - mean) / count;
}

/* A bench that fails in a later round keeps its earlier rounds. */
static void run_bench(cli_session* session, const bench_options* options, const bench_entry* entry,
                      bench_state* state) {
    const double wall = cli_wall_seconds(), cpu = cli_cpu_seconds(), busy = busy_seconds();
    if (state->count == 0) state->load_before = load_average();
    const int status = run_into_memory(session, options, entry, state);
    cli_progress_clear(&session->progress);
    if (status == CLI_DONE) {
        const double seconds = cli_wall_seconds() - wall;
        const double theirs = busy_seconds() - busy - (cli_cpu_seconds() - cpu);
        state->status = CLI_DONE;
        state->seconds = add_to_mean(state->seconds, seconds, state->count);
        state->others_busy = add_to_mean(state->others_busy, theirs < 0 ? 0 : theirs / seconds, state->count);
    } else if (state->count == 0 && !cli_interrupted()) {
        state->status = status;
        snprintf(state->message, sizeof state->message, "%s", cli_last_message());
    }
}

static json_t* result_of(bench_state* state) {
    json_t* result = json_object();
    json_object_set_new(result, "load_before", bench_rounded(state->load_before));
    if (state->status == CLI_DONE) {
        json_object_set_new(result, "others_busy", bench_rounded(state->others_busy));
        json_object_set_new(result, "seconds", bench_rounded(state->seconds));
        json_object_set_new(result, "timings", bench_collect_timings(state->rounds, state->count));
        json_object_set(result, "results", state->rounds[0]);
    } else {
        json_object_set_new(result, state->status == CLI_USAGE ? "skipped" : "failed",
                            json_stringn_nocheck(state->message, strlen(state->message)));
    }
    return result;
}

/* ---- all benches ---- */

static json_t* describe_run(const cli_session* session, const bench_options* options, int rounds) {
    const time_t now = time(NULL);
    struct tm utc;
    char date[32];
    const int32_t size[2] = {options->size_given ? options->size[0] : 0, options->size_given ? options->size[1] : 0};
    gmtime_r(&now, &utc);
    strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", &utc);
    return json_pack("{s:s, s:i, s:s, s:s, s:i, s:i, s:s, s:b, s:i, s:[i, i], s:i, s:i, s:i}", "format",
                     bench_format_name, "format_version", BENCH_FORMAT_VERSION, "version", ty_version(), "date", date,
                     "processors", (int)sysconf(_SC_NPROCESSORS_ONLN), "threads", ty_context_threads(session->context),
                     "isa", bench_isa(), "quick", options->quick, "spp", options->spp, "size", size[0], size[1], "side",
                     options->side, "runs", options->runs, "rounds", rounds);
}

static void run_round(cli_session* session, const bench_options* options, const bench_entry* const* entries, int count,
                      int round, int rounds, bench_state* states) {
    for (int i = 0; i < count && !cli_interrupted(); ++i) {
        char stage[64];
        if (states[i].status > CLI_DONE || states[i].count < round) continue;
        snprintf(stage, sizeof stage, "bench %s", entries[i]->name);
        if (rounds > 1) snprintf(stage, sizeof stage, "bench %s, round %d of %d", entries[i]->name, round + 1, rounds);
        if (count * rounds > 1)
            cli_progress_step(&session->progress, stage, i + round * count, count * rounds,
                              cli_wall_seconds() - session->started);
        run_bench(session, options, entries[i], &states[i]);
    }
}

json_t* bench_run_all(cli_session* session, const bench_options* options, const bench_entry* const* entries, int count,
                      int rounds) {
    static bench_state states[BENCH_COUNT];
    json_t *results = describe_run(session, options, rounds), *benches = json_object();
    for (int i = 0; i < count; ++i) states[i] = (bench_state){.status = CLI_GO};
    for (int round = 0; round < rounds; ++round) run_round(session, options, entries, count, round, rounds, states);
    json_object_set_new(results, "complete", json_boolean(!cli_interrupted()));
    json_object_set_new(results, "benches", benches);
    for (int i = 0; i < count; ++i) {
        if (states[i].status != CLI_GO) json_object_set_new(benches, entries[i]->name, result_of(&states[i]));
        for (int r = 0; r < states[i].count; ++r) json_decref(states[i].rounds[r]);
    }
    return results;
}
