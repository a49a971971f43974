/* Results of benches as tables for documentation. */
#ifndef TY_BENCH_MARKDOWN_H
#define TY_BENCH_MARKDOWN_H

#include "bench/results.h"

typedef struct bench_tables {
    const json_t *results, *before; /* as read or measured; before NULL: no comparison */
} bench_tables;

/* A cli_print_fn; user is a bench_tables. */
ty_result bench_print_markdown(ty_context* context, FILE* file, const void* user);

#endif
