/* Comparison of benches with an earlier run. */
#ifndef TY_BENCH_COMPARE_H
#define TY_BENCH_COMPARE_H

#include "bench/results.h"

/* A timing present in both results. */
typedef struct bench_change {
    const bench_result* bench;
    const bench_timing *now, *before;
    double slower; /* time over earlier time; for rates the inverse ratio */
    bool disjoint; /* the ranges of the rounds do not overlap */
} bench_change;

typedef struct bench_comparison {
    const bench_results *now, *before;
    bench_change* changes;
    size_t count;
    size_t only_now, only_before; /* timings missing in the other results */
} bench_comparison;

/* Errors: TY_ERROR_MEMORY. */
ty_result bench_compare(const bench_results* now, const bench_results* before, bench_comparison* out);
void bench_free_comparison(bench_comparison* comparison);

/* The change of a timing of a bench, or NULL. */
const bench_change* bench_find_change(const bench_comparison* comparison, const bench_timing* now);

/* True if a change exceeds the threshold (0.15), and the ranges of the rounds do not overlap. */
bool bench_is_slower(const bench_change* change, double threshold);
bool bench_is_faster(const bench_change* change, double threshold);
/* The number of slower timings. */
size_t bench_count_slower(const bench_comparison* comparison, double threshold);

/* Warns on stderr of different versions, machines and options, one line each. */
void bench_warn_differences(cli_session* session, const bench_comparison* comparison, const char* path);
void bench_print_comparison(FILE* file, const bench_comparison* comparison, const char* path, double threshold);
/* Writes a member of the open object. */
void bench_write_comparison(json_writer* json, const bench_comparison* comparison, const char* path, double threshold);

/* Formats a time or rate with its unit: "12.3 ms". */
void bench_format_timing(const char* name, double value, char out[40]);

#endif
