/* Results of benches, as stored in files: the JSON of each bench, and the times and rates in it, by name. */
#ifndef TY_BENCH_RESULTS_H
#define TY_BENCH_RESULTS_H

#include "cli/session.h"

struct json_t; /* json_t of the JSON library */

enum { BENCH_FORMAT_VERSION = 1, BENCH_TIMING_NAME = 128, BENCH_ROUNDS_MAX = 32 };

/* A time or a rate. */
typedef struct bench_timing {
    char name[BENCH_TIMING_NAME]; /* "scenes/cube_g0/cpu_seconds" */
    double median, min, max;      /* over the rounds */
} bench_timing;

/* One bench. */
typedef struct bench_result {
    const char* name;
    int status;                              /* CLI_DONE; CLI_USAGE: skipped, because its input is missing */
    char message[512];                       /* reason of a skip or failure */
    double load_before;                      /* one-minute load average before the first round; NaN: unknown */
    double other_load;                       /* processors busy with other programs during the run; NaN: unknown */
    double seconds;                          /* seconds of a round */
    struct json_t* rounds[BENCH_ROUNDS_MAX]; /* JSON of each round */
    int round_count;
    bench_timing* timings;
    size_t timing_count;
} bench_result;

/* The results of one call of `tyndall bench`, or of a file. */
typedef struct bench_results {
    char version[32], date[32], isa[32]; /* date: UTC, ISO 8601 */
    int processors, threads, runs, rounds;
    int spp, size[2], side; /* as in bench_options; size 0: not given */
    bool quick, complete;   /* complete: not interrupted */
    bench_result* benches;
    int count;
    struct json_t* file; /* the parsed file; NULL: none */
} bench_results;

/* True for rates, where larger is better; false for times. */
bool bench_is_rate(const char* timing_name);
/* The unit of a timing: "s", "ns", "GFLOP/s", "1/s" or "", and the factor to that unit. */
const char* bench_timing_unit(const char* timing_name);

/* Adds the JSON text of a round. Errors: TY_ERROR_MEMORY. */
ty_result bench_add_round(bench_result* result, const char* text, size_t size);
/* Computes median, minimum and maximum over all rounds. Errors: TY_ERROR_MEMORY. */
ty_result bench_finish_result(bench_result* result);
void bench_free_results(bench_results* results);

/* The timing of a name, or NULL. */
const bench_timing* bench_find_timing(const bench_result* result, const char* name);
const bench_result* bench_find_result(const bench_results* results, const char* name);

/* Reads a file of bench_write_results: CLI_GO, or CLI_USAGE after a message. */
int bench_read_results(cli_session* session, const char* path, bench_results* out);
/* Writes members of the open object. */
void bench_write_results(json_writer* json, const bench_results* results);

#endif
