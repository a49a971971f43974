/* Running benches one after the other and keeping what they measure. */
#ifndef TY_BENCH_RUN_H
#define TY_BENCH_RUN_H

#include "bench/list.h"
#include "bench/results.h"

/* Runs entries, all of them in each round, and keeps what they measure; a bench that fails hinders none of the others,
 * and is left out of further rounds. Once the user interrupts, what was measured until then is kept. Gives CLI_GO, also
 * when benches failed, or an exit status after a message. out is for bench_free_results either way. */
int bench_run_all(cli_session* session, const bench_options* options, const bench_entry* const* entries, int count,
                  int rounds, bench_results* out);

#endif
