/* Results of benches, as stored in files: the output of each bench, and the times and rates in it, by name. */
#ifndef TY_BENCH_RESULTS_H
#define TY_BENCH_RESULTS_H

#include "cli/session/session.h"

#include <jansson.h>

enum { BENCH_FORMAT_VERSION = 1, BENCH_TIMING_NAME = 128, BENCH_ROUNDS_MAX = 32 };
extern const char bench_format_name[];

/* A time or a rate over the rounds; median 0: there is none. */
typedef struct bench_timing {
    double median, min, max;
} bench_timing;

/* The timing of a name among the timings of a bench. */
bench_timing bench_get_timing(const json_t* timings, const char* name);
/* True for rates, where larger is better; false for times. */
bool bench_is_rate(const char* timing_name);
/* Formats a time or rate with its unit: "12.3 ms". */
void bench_format_timing(const char* name, double value, char out[40]);

/* {"scenes/cube_g0/cpu_seconds": [median, min, max], ...} of the outputs of one bench in all rounds. */
json_t* bench_collect_timings(json_t* const* rounds, int count);

/* A number of an object, or NaN. */
double bench_number(const json_t* object, const char* key);
/* A number rounded to five digits, more than the precision of timings; NaN becomes null. */
json_t* bench_rounded(double value);

/* Reads a file: CLI_GO, or CLI_USAGE after a message. The caller frees *out with json_decref. */
int bench_read_results(cli_session* session, const char* path, json_t** out);
/* Writes a value as a member of the open object; name NULL: as an element. */
void bench_write_value(json_writer* json, const char* name, const json_t* value);

#endif
