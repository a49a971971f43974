/* Memory bandwidth: what benches hold the bytes that an algorithm touches against. */
#ifndef TY_BENCH_MEMORY_H
#define TY_BENCH_MEMORY_H

#include <tyndall/base.h>

/* Three arrays larger than the caches. */
typedef struct bench_memory {
    float* arrays[3];
    int64_t count; /* floats in each */
} bench_memory;

/* false when memory is short; closing is for the caller either way. */
bool bench_memory_open(bench_memory* out);
void bench_memory_close(bench_memory* memory);

/* One of several equal parts of the arrays. */
typedef struct bench_memory_part {
    int64_t part, parts;
} bench_memory_part;

/* Bytes per second of going through a part once, on so many threads: a[i] = b[i], and a[i] = b[i] + 3 c[i]. Reads and
 * writes count, what the processor reads before it writes does not. */
double bench_memory_copy(ty_context* context, const bench_memory* memory, bench_memory_part part, int64_t threads);
double bench_memory_triad(ty_context* context, const bench_memory* memory, bench_memory_part part, int64_t threads);

#endif
