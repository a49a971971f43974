/* The arithmetic loop of machine.c, one build per instruction set. */
#ifndef TY_BENCH_FMA_H
#define TY_BENCH_FMA_H

#include <stdint.h>

/* Runs rounds of multiply-adds and stores the number of floating-point operations per round; the result only prevents
 * the compiler from removing the work. */
typedef float (*bench_fma_fn)(int64_t rounds, double* operations_per_round);

float bench_fma_v1(int64_t rounds, double* operations_per_round);
float bench_fma_v3(int64_t rounds, double* operations_per_round);
float bench_fma_v4(int64_t rounds, double* operations_per_round);

#endif
