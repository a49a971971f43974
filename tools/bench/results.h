/* What benches measured, as a file keeps it: the JSON that each wrote, and the times and rates in it, by name. */
#ifndef TY_BENCH_RESULTS_H
#define TY_BENCH_RESULTS_H

#include "cli/session.h"

struct json_t; /* the JSON library's */

enum { BENCH_FORMAT_VERSION = 1, BENCH_TIMING_NAME = 128, BENCH_ROUNDS_MAX = 32 };

/* A time or a rate. */
typedef struct bench_timing {
    char name[BENCH_TIMING_NAME]; /* "scenes/cube_g0/cpu_seconds" */
    double median, least, most;   /* of the rounds */
} bench_timing;

/* One bench. */
typedef struct bench_result {
    const char* name;
    int status;         /* CLI_DONE, or why there is nothing: CLI_USAGE: what it needs is not there */
    char message[512];  /* why, if so */
    double load_before; /* the system's load average of a minute, before its first round; NaN: not known */
    double others;      /* processors that others kept busy while it ran; NaN: not known */
    double seconds;     /* of a round */
    struct json_t* rounds[BENCH_ROUNDS_MAX]; /* what it wrote */
    int round_count;
    bench_timing* timings;
    size_t timing_count;
} bench_result;

/* All that one call of `tyndall bench` measured, or a file of it. */
typedef struct bench_results {
    char version[32], date[32], isa[32]; /* date: UTC, ISO 8601 */
    int processors, threads, runs, rounds;
    int spp, size[2], side; /* as bench_options has them; size 0: not given */
    bool quick, complete;   /* complete: not interrupted */
    bench_result* benches;
    int count;
    struct json_t* file; /* what was read; NULL: nothing was */
} bench_results;

/* Whether more of it is better: rates, against times. */
bool bench_is_rate(const char* timing_name);
/* The unit of a timing: "s", "ns", "GFLOP/s", "1/s" or "", and what to multiply it with for that. */
const char* bench_timing_unit(const char* timing_name);

/* Takes the JSON text that a bench wrote in a round. Errors: TY_ERROR_MEMORY. */
ty_result bench_add_round(bench_result* result, const char* text, size_t size);
/* Once all rounds are in: their medians, least and most. Errors: TY_ERROR_MEMORY. */
ty_result bench_finish_result(bench_result* result);
void bench_free_results(bench_results* results);

/* The timing of that name, or NULL. */
const bench_timing* bench_find_timing(const bench_result* result, const char* name);
const bench_result* bench_find_result(const bench_results* results, const char* name);

/* Reads what bench_write_results wrote: CLI_GO, or CLI_USAGE after a message. */
int bench_read_results(cli_session* session, const char* path, bench_results* out);
/* Members of the open object. */
void bench_write_results(json_writer* json, const bench_results* results);

#endif
