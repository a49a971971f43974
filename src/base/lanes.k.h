/* Vectors of floats, as wide as the instruction set that a kernel is built for, in the vector extensions that gcc and
 * clang share (base/simd.h has more of them). A thread of other devices has one lane. */
#ifndef TY_BASE_LANES_K_H
#define TY_BASE_LANES_K_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* For functions that must be inlined because some of their arguments are constants. */
#define TY_INLINE static inline __attribute__((always_inline, unused))

/* Before loops of few turns over arrays that threads of other devices are to hold in registers. */
#if defined(TY_DEVICE) && defined(__clang__)
#define TY_UNROLL _Pragma("unroll")
#else
#define TY_UNROLL
#endif

#if defined(TY_DEVICE)
enum { TY_LANE_BYTES = 4 };
#elif defined(__AVX512F__)
enum { TY_LANE_BYTES = 64 };
#elif defined(__AVX__)
enum { TY_LANE_BYTES = 32 };
#else
enum { TY_LANE_BYTES = 16 };
#endif
enum { TY_LANES = TY_LANE_BYTES / sizeof(float) };

typedef float ty_lanes __attribute__((vector_size(TY_LANE_BYTES)));
typedef int32_t ty_int_lanes __attribute__((vector_size(TY_LANE_BYTES)));

TY_INLINE ty_lanes ty_lanes_load(const float* from) {
    ty_lanes value;
    memcpy(&value, from, sizeof value);
    return value;
}

TY_INLINE void ty_lanes_store(float* to, ty_lanes value) {
    memcpy(to, &value, sizeof value);
}

TY_INLINE ty_lanes ty_lanes_abs(ty_lanes value) {
    return (ty_lanes)((ty_int_lanes)value & 0x7fffffff);
}

#endif
