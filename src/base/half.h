/* IEEE half floats as 16-bit words, in integer arithmetic, so that all builds round identically. */
#ifndef TY_BASE_HALF_H
#define TY_BASE_HALF_H

#include "base/kernel.h"

TY_FN float ty_half_to_float(uint16_t half) {
    const uint32_t sign = (uint32_t)(half & 0x8000u) << 16;
    const uint32_t magnitude_bits = (uint32_t)(half & 0x7fffu) << 13;
    /* Multiplying by 2^112 moves the exponent bias from 15 to 127 and normalises subnormals on the way. */
    const float scaled = ty_float_from_bits(magnitude_bits) * 0x1p112f;
    const uint32_t bits = (half & 0x7c00u) == 0x7c00u ? magnitude_bits | 0x7f800000u : ty_bits_from_float(scaled);
    return ty_float_from_bits(bits | sign);
}

/* Rounds to nearest even; overflows to infinity. */
TY_FN uint16_t ty_float_to_half(float value) {
    const uint32_t bits = ty_bits_from_float(value);
    const uint32_t sign = bits >> 16 & 0x8000u;
    const uint32_t magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u) return (uint16_t)(sign | 0x7e00u);
    if (magnitude >= 0x477ff000u) return (uint16_t)(sign | 0x7c00u);
    if (magnitude < 0x38800000u) {
        /* Subnormal: adding 0.5 leaves value * 2^24, rounded, in the low bits of the mantissa. */
        const float shifted = ty_float_from_bits(magnitude) + 0.5f;
        return (uint16_t)(sign | (ty_bits_from_float(shifted) - 0x3f000000u));
    }
    const uint32_t odd = magnitude >> 13 & 1u;
    return (uint16_t)(sign | ((magnitude - 0x38000000u + 0xfffu + odd) >> 13));
}

#endif
