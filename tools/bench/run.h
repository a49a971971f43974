/* Running benches in sequence and storing their results. */
#ifndef TY_BENCH_RUN_H
#define TY_BENCH_RUN_H

#include "bench/list.h"
#include "bench/results.h"

/* Runs all entries in each round and stores their results; a failed bench is left out of further rounds, and the others
 * continue. After an interruption the results so far are kept. Returns CLI_GO, also when benches failed, or an exit
 * status after a message. The caller frees out with bench_free_results in any case. */
int bench_run_all(cli_session* session, const bench_options* options, const bench_entry* const* entries, int count,
                  int rounds, bench_results* out);

#endif
