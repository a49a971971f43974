/* What benches measured beside what an earlier run did. */
#ifndef TY_BENCH_COMPARE_H
#define TY_BENCH_COMPARE_H

#include "bench/results.h"

/* One timing of both. */
typedef struct bench_change {
    const bench_result* bench;
    const bench_timing *now, *before;
    double slower; /* times as slow as before; of rates the inverse */
    bool apart;    /* the ranges of the rounds do not overlap */
} bench_change;

typedef struct bench_comparison {
    const bench_results *now, *before;
    bench_change* changes;
    size_t count;
    size_t only_now, only_before; /* timings that the other one does not have */
} bench_comparison;

/* Errors: TY_ERROR_MEMORY. */
ty_result bench_compare(const bench_results* now, const bench_results* before, bench_comparison* out);
void bench_free_comparison(bench_comparison* comparison);

/* The change of a timing of a bench, or NULL. */
const bench_change* bench_find_change(const bench_comparison* comparison, const bench_timing* now);

/* Whether a change is by more than so much (0.15), and not within what rounds differ by anyway. */
bool bench_is_slower(const bench_change* change, double threshold);
bool bench_is_faster(const bench_change* change, double threshold);
/* How many of them are. */
size_t bench_count_slower(const bench_comparison* comparison, double threshold);

/* What speaks against comparing them: other versions, machines, options; a line each on stderr. */
void bench_warn_differences(cli_session* session, const bench_comparison* comparison, const char* path);
void bench_print_comparison(FILE* file, const bench_comparison* comparison, const char* path, double threshold);
/* A member of the open object. */
void bench_write_comparison(json_writer* json, const bench_comparison* comparison, const char* path, double threshold);

/* A time or rate with its unit: "12.3 ms". */
void bench_format_timing(const char* name, double value, char out[40]);

#endif
