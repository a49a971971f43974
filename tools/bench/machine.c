/* tyndall bench machine: peak performance of the processor and its memory, as a scale for other timings. */
#include "bench/bench.h"
#include "bench/fma.h"
#include "bench/memory.h"

#include <stdlib.h>

enum { RUNS = 7 };

typedef struct machine {
    const char* isa;
    double array_bytes;
    /* medians, [0] one thread, [1] all threads */
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

const char* bench_isa(void) {
    const char* isa;
    choose_fma(&isa);
    return isa;
}

/* The timed work of one thread. */
typedef struct work {
    bench_fma_fn fma;
    double operations_per_round;
    float sink;
} work;

enum { FMA_ROUNDS = 20000 };

static void run_fma(void* user, int64_t index, int32_t worker) {
    (void)worker;
    work* task = (work*)user + index;
    task->sink += task->fma(FMA_ROUNDS, &task->operations_per_round);
}

static double fma_gflops(ty_context* context, int64_t threads, work* works) {
    const double start = cli_wall_seconds();
    ty_parallel_for(context, threads, run_fma, works);
    return 1e-9 * (double)threads * FMA_ROUNDS * works[0].operations_per_round / (cli_wall_seconds() - start);
}

double bench_fma_gflops(ty_context* context) {
    const int64_t threads = ty_context_threads(context);
    work* works = calloc((size_t)threads, sizeof *works);
    const char* isa;
    double gflops[RUNS];
    if (works == NULL) return 0;
    for (int64_t i = 0; i < threads; ++i) works[i].fma = choose_fma(&isa);
    for (int run = -1; run < RUNS; ++run) gflops[run < 0 ? 0 : run] = fma_gflops(context, threads, works);
    free(works);
    return bench_median(gflops, RUNS);
}

/* Medians after a warm-up run. */
static void measure_threads(ty_context* context, int64_t threads, work* works, const bench_memory* memory, int all,
                            machine* out) {
    double gflops[RUNS], copy[RUNS], triad[RUNS];
    const bench_memory_slice entire = {0, 1};
    for (int run = -1; run < RUNS; ++run) {
        const int to = run < 0 ? 0 : run;
        gflops[to] = fma_gflops(context, threads, works);
        copy[to] = 1e-9 * bench_memory_copy(context, memory, entire, threads);
        triad[to] = 1e-9 * bench_memory_triad(context, memory, entire, threads);
    }
    out->gflops[all] = bench_median(gflops, RUNS);
    out->copy[all] = bench_median(copy, RUNS);
    out->triad[all] = bench_median(triad, RUNS);
}

static int measure(ty_context* context, machine* out) {
    const int64_t threads = ty_context_threads(context);
    work* works = calloc((size_t)threads, sizeof *works);
    bench_memory memory;
    const bool allocated = bench_memory_open(&memory) && works != NULL;
    if (allocated) {
        const bench_fma_fn fma = choose_fma(&out->isa);
        for (int64_t i = 0; i < threads; ++i) works[i].fma = fma;
        out->array_bytes = (double)memory.count * sizeof(float);
        measure_threads(context, 1, works, &memory, 0, out);
        measure_threads(context, threads, works, &memory, 1, out);
    }
    bench_memory_close(&memory);
    free(works);
    return allocated ? CLI_DONE : cli_fail(CLI_FAILED, "not enough memory");
}

int bench_machine(const bench_session* bench) {
    machine result = {0};
    const int status = measure(bench->session->context, &result);
    if (status != CLI_DONE) return status;
    const int32_t threads = ty_context_threads(bench->session->context);
    json_text(bench->json, "isa", result.isa);
    json_numbers(bench->json, "threads", (const double[]){1, threads}, 2);
    json_numbers(bench->json, "fma_gflops", result.gflops, 2);
    json_numbers(bench->json, "copy_gb_per_second", result.copy, 2);
    json_numbers(bench->json, "triad_gb_per_second", result.triad, 2);
    json_number(bench->json, "array_bytes", result.array_bytes);
    return CLI_DONE;
}
