/* Running benches. */
#define _GNU_SOURCE
#include "bench/run.h"
#include "cli/text_file.h"

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

static void record_failure(cli_session* session, int status, bench_result* result) {
    cli_progress_clear(&session->progress);
    result->status = status;
    snprintf(result->message, sizeof result->message, "%s", cli_last_message());
}

/* Output is buffered in memory, so that a failed bench leaves no partial output. */
static int run_into_memory(cli_session* session, const bench_options* options, const bench_entry* entry,
                           bench_result* result) {
    cli_text memory;
    if (!cli_text_open(&memory)) return cli_fail(CLI_FAILED, "not enough memory");
    json_writer writer = json_begin(memory.file);
    const bench_session bench = {session, options, &writer};
    json_open_object(&writer, NULL);
    int status = entry->run(&bench);
    if (status == CLI_DONE) json_close_object(&writer);
    char* text = cli_text_close(&memory);
    if (status == CLI_DONE && !(text != NULL && bench_add_round(result, text, memory.size) == TY_OK))
        status = cli_fail(CLI_FAILED, "not enough memory");
    free(text);
    return status;
}

static void run_bench(cli_session* session, const bench_options* options, const bench_entry* entry,
                      bench_result* result) {
    const double wall = cli_wall_seconds(), cpu = cli_cpu_seconds(), busy = busy_seconds();
    if (result->round_count == 0) result->load_before = load_average();
    const int status = run_into_memory(session, options, entry, result);
    if (status != CLI_DONE) {
        /* A bench that fails in a later round keeps its earlier rounds. */
        if (result->round_count == 0 && !cli_interrupted()) record_failure(session, status, result);
        return;
    }
    const double seconds = cli_wall_seconds() - wall;
    const double theirs = busy_seconds() - busy - (cli_cpu_seconds() - cpu);
    const double busy_others = theirs < 0 ? 0 : theirs / seconds; /* NaN is preserved */
    const int before = result->round_count - 1;
    result->status = CLI_DONE;
    result->seconds = (before * result->seconds + seconds) / result->round_count;
    result->other_load = before == 0 ? busy_others : (before * result->other_load + busy_others) / result->round_count;
    cli_progress_clear(&session->progress);
}

/* ---- all benches ---- */

static void describe_run(cli_session* session, const bench_options* options, int rounds, bench_results* out) {
    const time_t now = time(NULL);
    struct tm utc;
    gmtime_r(&now, &utc);
    snprintf(out->version, sizeof out->version, "%s", ty_version());
    snprintf(out->isa, sizeof out->isa, "%s", bench_isa());
    strftime(out->date, sizeof out->date, "%Y-%m-%dT%H:%M:%SZ", &utc);
    out->processors = (int)sysconf(_SC_NPROCESSORS_ONLN);
    out->threads = ty_context_threads(session->context);
    out->quick = options->quick;
    out->runs = options->runs;
    out->spp = options->spp;
    out->side = options->side;
    for (int i = 0; i < 2; ++i) out->size[i] = options->size_given ? options->size[i] : 0;
    out->rounds = rounds;
}

static void run_round(cli_session* session, const bench_options* options, const bench_entry* const* entries, int round,
                      bench_results* out) {
    for (int i = 0; i < out->count && !cli_interrupted(); ++i) {
        bench_result* result = &out->benches[i];
        char stage[64];
        if (result->status > CLI_DONE || result->round_count < round) continue;
        if (out->rounds > 1)
            snprintf(stage, sizeof stage, "bench %s, round %d of %d", result->name, round + 1, out->rounds);
        else
            snprintf(stage, sizeof stage, "bench %s", result->name);
        if (out->count * out->rounds > 1)
            cli_progress_step(&session->progress, stage, i + round * out->count, out->count * out->rounds,
                              cli_wall_seconds() - session->started);
        run_bench(session, options, entries[i], result);
    }
}

int bench_run_all(cli_session* session, const bench_options* options, const bench_entry* const* entries, int count,
                  int rounds, bench_results* out) {
    *out = (bench_results){.count = count, .benches = calloc((size_t)count, sizeof *out->benches)};
    if (out->benches == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    describe_run(session, options, rounds, out);
    for (int i = 0; i < count; ++i)
        out->benches[i] =
            (bench_result){.name = entries[i]->name, .status = CLI_GO, .other_load = NAN, .load_before = NAN};
    for (int round = 0; round < rounds; ++round) run_round(session, options, entries, round, out);
    out->complete = !cli_interrupted();
    for (int i = 0; i < count; ++i)
        if (out->benches[i].status == CLI_DONE && bench_finish_result(&out->benches[i]) != TY_OK)
            return cli_fail(CLI_FAILED, "not enough memory");
    return CLI_GO;
}
