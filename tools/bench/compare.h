/* Comparison of benches with an earlier run. */
#ifndef TY_BENCH_COMPARE_H
#define TY_BENCH_COMPARE_H

#include "bench/results.h"

/* A time over the earlier time, for rates the inverse ratio; 0: there is no earlier one. */
double bench_times_as_slow(const char* timing_name, bench_timing now, bench_timing before);

/* The comparison as it is written to files. A change is listed as slower or faster if it exceeds the threshold (0.15)
 * and the ranges of the rounds do not overlap. Freed with json_decref. */
json_t* bench_compare(const json_t* now, const json_t* before, const char* path, double threshold);

/* Warns on stderr of different versions, machines and options, one line each. */
void bench_warn_differences(cli_session* session, const json_t* now, const json_t* before, const char* path);
void bench_print_comparison(FILE* file, const json_t* comparison);

#endif
