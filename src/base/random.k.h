/* Random numbers as functions of (seed, item, sample, dimension): no state outlives a sample, so results are
 * independent of scheduling.
 *
 * The first TY_SOBOL_DIMENSIONS numbers of a sample are Owen-scrambled Sobol points, independently scrambled per item
 * and dimension (hash-based scrambling: Laine and Karras 2011, Burley 2020); the rest, and loops of unknown length, use
 * white noise from a counter-based generator (splitmix64: Steele et al. 2014). */
#ifndef TY_BASE_RANDOM_K_H
#define TY_BASE_RANDOM_K_H

#include "base/kernel.h"

enum { TY_SOBOL_DIMENSIONS = 16, TY_SOBOL_BITS = 24 };

/* Direction numbers, [dimension][bit], bit 31 first; filled by ty_sobol_matrices. */
typedef struct ty_sobol {
    uint32_t matrix[TY_SOBOL_DIMENSIONS][TY_SOBOL_BITS];
} ty_sobol;

/* Primitive polynomials and initial numbers of Joe and Kuo 2008 (new-joe-kuo-6), dimensions 1 to 16. */
void ty_sobol_matrices(ty_sobol* out);

typedef struct ty_sampler {
    TY_GLOBAL const ty_sobol* sobol;
    uint64_t key;      /* of this sample's white noise */
    uint64_t counter;  /* number of white noise values drawn */
    uint32_t scramble; /* of this item's Sobol points */
    uint32_t sample;
    int32_t dimension; /* number of Sobol values drawn */
} ty_sampler;

TY_FN uint64_t ty_mix64(uint64_t x) {
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9u;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

TY_FN uint32_t ty_mix32(uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

TY_FN uint32_t ty_reverse_bits(uint32_t x) {
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(x);
}

/* Owen scrambling: each bit is flipped depending on the bits above it, a random permutation of the binary tree over x.
 */
TY_FN uint32_t ty_owen_scramble(uint32_t x, uint32_t seed) {
    x = ty_reverse_bits(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return ty_reverse_bits(x);
}

TY_FN ty_sampler ty_sampler_begin(TY_GLOBAL const ty_sobol* sobol, uint64_t seed, uint64_t item, uint32_t sample) {
    ty_sampler random;
    const uint64_t base = ty_mix64(seed + 0x9e3779b97f4a7c15u) ^ ty_mix64(item + 0xd1b54a32d192ed03u);
    random.sobol = sobol;
    random.key = ty_mix64(base + sample);
    random.counter = 0;
    random.scramble = (uint32_t)(ty_mix64(base ^ 0x2545f4914f6cdd1du) >> 32);
    random.sample = sample;
    random.dimension = 0;
    return random;
}

/* White noise for a part of a sample that takes none of the sample's own numbers. */
TY_FN ty_sampler ty_sampler_branch(const ty_sampler* random) {
    ty_sampler branch = *random;
    branch.key =
        ty_mix64(random->key ^ ty_mix64(random->counter * 64 + (uint64_t)random->dimension + 0x6a09e667f3bcc909u));
    branch.counter = 0;
    branch.dimension = TY_SOBOL_DIMENSIONS;
    return branch;
}

TY_FN uint64_t ty_rng_bits(ty_sampler* random) {
    return ty_mix64(random->key + 0x9e3779b97f4a7c15u * ++random->counter);
}

/* [0, 1) from the top 24 bits of 32. */
TY_FN float ty_unit_float(uint32_t bits) {
    return (float)(bits >> 8) * 0x1p-24f;
}

/* White noise in [0, 1). */
TY_FN float ty_rng_uniform(ty_sampler* random) {
    return ty_unit_float((uint32_t)(ty_rng_bits(random) >> 32));
}

/* Next low-discrepancy number in [0, 1); white noise after the Sobol dimensions. */
TY_FN float ty_sobol_next(ty_sampler* random) {
    if (random->dimension >= TY_SOBOL_DIMENSIONS) return ty_rng_uniform(random);
    TY_GLOBAL const uint32_t* matrix = random->sobol->matrix[random->dimension];
    uint32_t point = 0;
    for (uint32_t rest = random->sample; rest != 0; rest &= rest - 1) point ^= matrix[__builtin_ctz(rest)];
    const uint32_t seed = ty_mix32(random->scramble + 0x9e3779b9u * (uint32_t)++random->dimension);
    return ty_unit_float(ty_owen_scramble(point, seed));
}

/* Exponentially distributed with mean 1, from u in [0, 1). */
TY_FN float ty_exponential(float u) {
    return -ty_logf(1.0f - u);
}

#endif
