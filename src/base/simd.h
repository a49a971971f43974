/* Vectors of floats as wide as the instruction set that a kernel is built for, in the vector extensions that gcc and
 * clang share; intrinsics stand only where both compile the plain code to something slower. A thread of a device has
 * one lane. */
#ifndef TY_BASE_SIMD_H
#define TY_BASE_SIMD_H

#include "base/lanes.k.h"

#if defined(__SSE2__) && !defined(TY_DEVICE)
#include <immintrin.h>
#endif

typedef float ty_memory_lanes __attribute__((vector_size(TY_LANE_BYTES), may_alias)); /* in arrays of floats */

/* ---- memory ---- */

/* Of addresses that are multiples of TY_LANE_BYTES. */
TY_INLINE ty_lanes ty_lanes_load_aligned(const float* from) {
    return *(const ty_memory_lanes*)from;
}

TY_INLINE void ty_lanes_store_aligned(float* to, ty_lanes value) {
    *(ty_memory_lanes*)to = value;
}

/* ---- masks ---- */

/* One bit per lane where the processor has mask registers, else all bits of a lane or none. */
#if defined(__AVX512F__)
typedef __mmask16 ty_lane_mask;
#else
typedef ty_int_lanes ty_lane_mask;
#endif

/* The sign bits of the lanes: bit i belongs to lane i. */
TY_INLINE uint32_t ty_lanes_signs(ty_int_lanes value) {
#if defined(TY_DEVICE)
    return (uint32_t)(value[0] < 0);
#elif defined(__AVX512F__)
    return _mm512_movepi32_mask((__m512i)value);
#elif defined(__AVX__)
    return (uint32_t)_mm256_movemask_ps((__m256)value);
#elif defined(__SSE2__)
    return (uint32_t)_mm_movemask_ps((__m128)value);
#else
    uint32_t bits = 0;
    for (int i = 0; i < TY_LANES; ++i) bits |= (uint32_t)(value[i] < 0) << i;
    return bits;
#endif
}

TY_INLINE ty_lane_mask ty_lanes_greater(ty_lanes a, ty_lanes b) {
#if defined(__AVX512F__)
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_GT_OQ);
#else
    return a > b;
#endif
}

/* Bit i belongs to lane i. */
TY_INLINE uint32_t ty_mask_bits(ty_lane_mask mask) {
#if defined(__AVX512F__)
    return mask;
#else
    return ty_lanes_signs(mask);
#endif
}

/* value where the mask is set, else 0. */
TY_INLINE ty_lanes ty_lanes_keep(ty_lane_mask mask, ty_lanes value) {
#if defined(__AVX512F__)
    return (ty_lanes)_mm512_maskz_mov_ps(mask, (__m512)value);
#else
    return (ty_lanes)((ty_int_lanes)value & mask);
#endif
}

/* sum + a b where the mask is set, else sum. */
TY_INLINE ty_lanes ty_lanes_add_product(ty_lane_mask mask, ty_lanes sum, ty_lanes a, ty_lanes b) {
#if defined(__AVX512F__)
    return (ty_lanes)_mm512_mask3_fmadd_ps((__m512)a, (__m512)b, (__m512)sum, mask);
#else
    return sum + ty_lanes_keep(mask, a) * b;
#endif
}

/* sum + a where the mask is set, else sum. */
TY_INLINE ty_lanes ty_lanes_add(ty_lane_mask mask, ty_lanes sum, ty_lanes a) {
#if defined(__AVX512F__)
    return (ty_lanes)_mm512_mask_add_ps((__m512)sum, mask, (__m512)sum, (__m512)a);
#else
    return sum + ty_lanes_keep(mask, a);
#endif
}

/* ---- arithmetic ---- */

/* 1 / value to 2 ulp: one step of Newton's iteration where a division would keep the whole unit busy. */
TY_INLINE ty_lanes ty_lanes_invert(ty_lanes value) {
#if defined(__AVX512F__)
    const ty_lanes guess = (ty_lanes)_mm512_rcp14_ps((__m512)value);
    return guess * (2.0f - value * guess);
#else
    return 1.0f / value;
#endif
}

/* ---- sixteen lanes on every instruction set ---- */

typedef float ty_float16 __attribute__((vector_size(64)));
typedef int32_t ty_int16 __attribute__((vector_size(64))); /* as a mask: 0 or -1 in each lane */

/* from[index[i]]; by pointers, since without AVX-512 vectors of this width have no calling convention. */
TY_INLINE void ty_gather16(const float* from, const ty_int16* index, ty_float16* out) {
#if defined(__AVX512F__)
    *out = (ty_float16)_mm512_i32gather_ps((__m512i)*index, from, sizeof(float));
#else
    for (int32_t i = 0; i < 16; ++i) (*out)[i] = from[(*index)[i]];
#endif
}

TY_INLINE bool ty_any16(const ty_int16* mask) {
#if defined(__AVX512F__)
    return _mm512_test_epi32_mask((__m512i)*mask, (__m512i)*mask) != 0;
#else
    int32_t sum = 0;
    for (int32_t i = 0; i < 16; ++i) sum |= (*mask)[i];
    return sum != 0;
#endif
}

/* table[index[i]] for indices of 0 to 15. Clang has no __builtin_shuffle of variable indices. */
TY_INLINE void ty_permute16(const ty_int16* table, const ty_int16* index, ty_int16* out) {
#if defined(__clang__)
    for (int32_t i = 0; i < 16; ++i) (*out)[i] = (*table)[(*index)[i] & 15];
#else
    *out = __builtin_shuffle(*table, *index);
#endif
}

#endif
