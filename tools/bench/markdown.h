/* Results of benches as tables for documentation. */
#ifndef TY_BENCH_MARKDOWN_H
#define TY_BENCH_MARKDOWN_H

#include "bench/compare.h"

typedef struct bench_tables {
    const bench_results* results;
    const bench_comparison* comparison; /* or NULL */
} bench_tables;

/* A cli_print_fn; user is a bench_tables. */
ty_result bench_print_markdown(ty_context* context, FILE* file, const void* user);

#endif
