/* tyndall bench machine: what the processor and its memory can do at most, so that other timings mean something. */
#define _GNU_SOURCE
#include "cli/bench.h"
#include "cli/bench_fma.h"

#include <stdlib.h>
#include <unistd.h>

enum { RUNS = 7 };

typedef struct machine {
    const char* isa;
    double array_bytes;
    /* medians, [0] on one thread, [1] on all */
    double gflops[2], copy[2], triad[2]; /* 1e9 operations/s, 1e9 bytes/s */
} machine;

static bench_fma_fn choose_fma(const char** isa) {
#if defined(TY_ISA_X86)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
        *isa = "x86-64-v4";
        return bench_fma_v4;
    }
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) {
        *isa = "x86-64-v3";
        return bench_fma_v3;
    }
    *isa = "x86-64";
#else
    *isa = "x86-64";
#endif
    return bench_fma_v1;
}

/* One timed piece of work for every thread. */
typedef struct work {
    bench_fma_fn fma;
    int64_t rounds;
    double operations_per_round;
    float sink;
    float *a, *b, *c;
    int64_t begin, count;
} work;

static void run_fma(void* user, int64_t index, int32_t worker) {
    (void)worker;
    work* piece = (work*)user + index;
    piece->sink += piece->fma(piece->rounds, &piece->operations_per_round);
}

static void run_copy(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const work* piece = (work*)user + index;
    float* const a = piece->a + piece->begin;
    const float* const b = piece->b + piece->begin;
    for (int64_t i = 0; i < piece->count; ++i) a[i] = b[i];
}

static void run_triad(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const work* piece = (work*)user + index;
    float* const a = piece->a + piece->begin;
    const float* const b = piece->b + piece->begin;
    const float* const c = piece->c + piece->begin;
    for (int64_t i = 0; i < piece->count; ++i) a[i] = b[i] + 3.0f * c[i];
}

/* The median time of the body over pieces threads, after one run that does not count. */
static double median_seconds(ty_context* context, int64_t pieces, ty_parallel_fn body, work* works) {
    double seconds[RUNS];
    ty_parallel_for(context, pieces, body, works);
    for (int run = 0; run < RUNS; ++run) {
        const double start = cli_wall_seconds();
        ty_parallel_for(context, pieces, body, works);
        seconds[run] = cli_wall_seconds() - start;
    }
    return bench_median(seconds, RUNS);
}

static void measure_fma(ty_context* context, int64_t threads, bench_fma_fn fma, work* works, double* gflops) {
    for (int64_t i = 0; i < threads; ++i) works[i] = (work){.fma = fma, .rounds = 20000};
    const double seconds = median_seconds(context, threads, run_fma, works);
    *gflops = 1e-9 * (double)threads * 20000 * works[0].operations_per_round / seconds;
}

static void measure_memory(ty_context* context, int64_t threads, float* arrays[3], int64_t count, work* works,
                           double* copy, double* triad) {
    for (int64_t i = 0; i < threads; ++i) {
        const int64_t begin = count * i / threads, end = count * (i + 1) / threads;
        works[i] = (work){.a = arrays[0], .b = arrays[1], .c = arrays[2], .begin = begin, .count = end - begin};
    }
    const double bytes = (double)count * sizeof(float);
    *copy = 1e-9 * 2 * bytes / median_seconds(context, threads, run_copy, works);
    *triad = 1e-9 * 3 * bytes / median_seconds(context, threads, run_triad, works);
}

/* Larger than the caches, but no more than an eighth of the memory each. */
static int64_t array_floats(void) {
    double bytes = 128.0 * 1024 * 1024;
    const double cache = (double)sysconf(_SC_LEVEL3_CACHE_SIZE);
    if (2 * cache > bytes) bytes = 2 * cache;
    const double memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (memory > 0 && bytes > memory / 8) bytes = memory / 8;
    return (int64_t)(bytes / sizeof(float));
}

static int measure(ty_context* context, machine* out) {
    const int64_t threads = ty_context_threads(context);
    const int64_t count = array_floats();
    work* works = calloc((size_t)threads, sizeof *works);
    float* arrays[3];
    bool allocated = works != NULL;
    for (int i = 0; i < 3; ++i) {
        arrays[i] = malloc(sizeof(float) * (size_t)count);
        allocated = allocated && arrays[i] != NULL;
    }
    if (allocated) {
        for (int i = 0; i < 3; ++i)
            for (int64_t j = 0; j < count; ++j) arrays[i][j] = (float)(j & 1023);
        const bench_fma_fn fma = choose_fma(&out->isa);
        out->array_bytes = (double)count * sizeof(float);
        for (int all = 0; all < 2; ++all) {
            const int64_t pieces = all ? threads : 1;
            measure_fma(context, pieces, fma, works, &out->gflops[all]);
            measure_memory(context, pieces, arrays, count, works, &out->copy[all], &out->triad[all]);
        }
    }
    for (int i = 0; i < 3; ++i) free(arrays[i]);
    free(works);
    return allocated ? CLI_DONE : cli_fail(CLI_FAILED, "not enough memory");
}

int bench_machine(const bench_session* bench) {
    machine result = {0};
    const int status = measure(bench->session->context, &result);
    if (status != CLI_DONE) return status;
    const int32_t threads = ty_context_threads(bench->session->context);
    if (bench->json != NULL) {
        json_text(bench->json, "isa", result.isa);
        json_numbers(bench->json, "threads", (const double[]){1, threads}, 2);
        json_numbers(bench->json, "fma_gflops", result.gflops, 2);
        json_numbers(bench->json, "copy_gb_per_second", result.copy, 2);
        json_numbers(bench->json, "triad_gb_per_second", result.triad, 2);
        json_number(bench->json, "array_bytes", result.array_bytes);
        return CLI_DONE;
    }
    char bytes[24];
    cli_format_bytes(result.array_bytes, bytes);
    printf("machine (%s, medians of %d, arrays of %s)\n", result.isa, RUNS, bytes);
    printf("%-24s %12s %11d\n", "threads", "1", threads);
    printf("%-24s %12.1f %11.1f\n", "multiply-add, GFLOP/s", result.gflops[0], result.gflops[1]);
    printf("%-24s %12.1f %11.1f\n", "copy, GB/s", result.copy[0], result.copy[1]);
    printf("%-24s %12.1f %11.1f\n", "triad, GB/s", result.triad[0], result.triad[1]);
    return CLI_DONE;
}
