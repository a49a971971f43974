/* Running benches in sequence. */
#ifndef TY_BENCH_RUN_H
#define TY_BENCH_RUN_H

#include "bench/list.h"
#include "bench/results.h"

/* Runs all entries in each round; a failed bench is left out of further rounds, and the others continue. After an
 * interruption the results so far are kept. The results are as in a file of bench_read_results, and freed with
 * json_decref. */
json_t* bench_run_all(cli_session* session, const bench_options* options, const bench_entry* const* entries, int count,
                      int rounds);

#endif
