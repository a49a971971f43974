/* Memory bandwidth, the bound on the bytes that an algorithm reads and writes. */
#ifndef TY_BENCH_MEMORY_H
#define TY_BENCH_MEMORY_H

#include <tyndall/base.h>

/* Three arrays larger than the caches. */
typedef struct bench_memory {
    float* arrays[3];
    int64_t count; /* floats in each */
} bench_memory;

/* Returns false when memory is short; the caller closes in any case. */
bool bench_memory_open(bench_memory* out);
void bench_memory_close(bench_memory* memory);

/* Slice `index` of `count` equal slices of the arrays. */
typedef struct bench_memory_slice {
    int64_t index, count;
} bench_memory_slice;

/* Bytes per second of one pass over a slice: copy a[i] = b[i], and triad a[i] = b[i] + 3 c[i]. Reads and writes count,
 * write-allocate reads do not. */
double bench_memory_copy(ty_context* context, const bench_memory* memory, bench_memory_slice slice, int64_t threads);
double bench_memory_triad(ty_context* context, const bench_memory* memory, bench_memory_slice slice, int64_t threads);

#endif
