/* Memory bandwidth. */
#define _GNU_SOURCE
#include "bench/memory.h"
#include "cli/session/session.h"

#include <stdlib.h>
#include <unistd.h>

/* Larger than the caches, but no more than an eighth of the memory each. */
static int64_t array_floats(void) {
    double bytes = 128.0 * 1024 * 1024;
    const double cache = (double)sysconf(_SC_LEVEL3_CACHE_SIZE);
    if (2 * cache > bytes) bytes = 2 * cache;
    const double memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (memory > 0 && bytes > memory / 8) bytes = memory / 8;
    return (int64_t)(bytes / sizeof(float));
}

bool bench_memory_open(bench_memory* out) {
    *out = (bench_memory){.count = array_floats()};
    for (int i = 0; i < 3; ++i) {
        out->arrays[i] = malloc(sizeof(float) * (size_t)out->count);
        if (out->arrays[i] == NULL) return false;
        for (int64_t j = 0; j < out->count; ++j) out->arrays[i][j] = (float)(j & 1023);
    }
    return true;
}

void bench_memory_close(bench_memory* memory) {
    for (int i = 0; i < 3; ++i) free(memory->arrays[i]);
}

/* A pass over a slice of the arrays, in `tasks` tasks. */
typedef struct pass {
    const bench_memory* memory;
    bench_memory_slice slice;
    int64_t tasks;
} pass;

static int64_t slice_count(const pass* p) {
    return p->memory->count / p->slice.count;
}

static int64_t task_begin(const pass* p, int64_t index) {
    return slice_count(p) * p->slice.index + slice_count(p) * index / p->tasks;
}

static void run_copy(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const int64_t begin = task_begin(p, index), count = task_begin(p, index + 1) - begin;
    float* const a = p->memory->arrays[0] + begin;
    const float* const b = p->memory->arrays[1] + begin;
    for (int64_t i = 0; i < count; ++i) a[i] = b[i];
}

static void run_triad(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const int64_t begin = task_begin(p, index), count = task_begin(p, index + 1) - begin;
    float* const a = p->memory->arrays[0] + begin;
    const float* const b = p->memory->arrays[1] + begin;
    const float* const c = p->memory->arrays[2] + begin;
    for (int64_t i = 0; i < count; ++i) a[i] = b[i] + 3.0f * c[i];
}

static double bytes_per_second(ty_context* context, pass work, ty_parallel_fn body, int arrays) {
    const double bytes = arrays * (double)slice_count(&work) * sizeof(float);
    const double start = cli_wall_seconds();
    ty_parallel_for(context, work.tasks, body, &work);
    return bytes / (cli_wall_seconds() - start);
}

double bench_memory_copy(ty_context* context, const bench_memory* memory, bench_memory_slice slice, int64_t threads) {
    return bytes_per_second(context, (pass){memory, slice, threads}, run_copy, 2);
}

double bench_memory_triad(ty_context* context, const bench_memory* memory, bench_memory_slice slice, int64_t threads) {
    return bytes_per_second(context, (pass){memory, slice, threads}, run_triad, 3);
}
