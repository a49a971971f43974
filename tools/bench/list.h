/* The list of benches. */
#ifndef TY_BENCH_LIST_H
#define TY_BENCH_LIST_H

#include "bench/bench.h"

typedef struct bench_entry {
    const char* name;
    const char* summary;
    int (*run)(const bench_session* bench);
} bench_entry;

enum { BENCH_COUNT = 18 };
extern const bench_entry bench_entries[BENCH_COUNT];

#endif
