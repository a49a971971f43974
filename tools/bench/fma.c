/* Peak multiply-add throughput: independent chains in registers, at the vector width of TY_ISA. */
#include "bench/fma.h"

#if defined(__AVX512F__)
enum { BYTES = 64, CHAINS = 16 };
#elif defined(__AVX__)
enum { BYTES = 32, CHAINS = 12 };
#else
enum { BYTES = 16, CHAINS = 10 };
#endif
enum { LANES = BYTES / sizeof(float), STEPS = 64 };

typedef float vector __attribute__((vector_size(BYTES)));

#define JOIN2(a, b) a##b
#define JOIN(a, b) JOIN2(a, b)

float JOIN(bench_fma_, TY_ISA)(int64_t rounds, double* operations_per_round) {
    vector chains[CHAINS], factor, term;
    for (int lane = 0; lane < LANES; ++lane) {
        factor[lane] = 0.5f;
        term[lane] = 0.25f + 0.01f * (float)lane;
        for (int c = 0; c < CHAINS; ++c) chains[c][lane] = (float)(c + lane);
    }
    for (int64_t round = 0; round < rounds; ++round) {
#pragma GCC unroll 8
        for (int step = 0; step < STEPS; ++step) {
#pragma GCC unroll 16
            for (int c = 0; c < CHAINS; ++c) chains[c] = chains[c] * factor + term;
        }
    }
    vector total = chains[0];
    for (int c = 1; c < CHAINS; ++c) total += chains[c];
    float sum = 0;
    for (int lane = 0; lane < LANES; ++lane) sum += total[lane];
    *operations_per_round = 2.0 * LANES * CHAINS * STEPS;
    return sum;
}
