/* Random numbers of tests. */
#ifndef TY_TESTS_UNIFORM_H
#define TY_TESTS_UNIFORM_H

#include <stdint.h>

/* Uniform in [0, 1); splitmix64, apart from the library's own. */
static inline double uniform(uint64_t* state) {
    uint64_t x = *state += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return (double)((x ^ x >> 31) >> 11) * 0x1p-53;
}

#endif
