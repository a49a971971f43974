/* A decoder of BC6H for tests, after the Khronos Data Format Specification 1.3. */
#ifndef TY_TESTS_BC6H_DECODER_H
#define TY_TESTS_BC6H_DECODER_H

#include "base/half.h"
#include "io/textures/bc6h.h"

#include <stdbool.h>

static inline int32_t take_bits(const uint8_t* block, int32_t* at, int32_t count) {
    int32_t value = 0;
    for (int32_t i = 0; i < count; ++i, ++*at) value |= (block[*at / 8] >> (*at % 8) & 1) << i;
    return value;
}

static inline int32_t extend_sign(int32_t value, int32_t bits) {
    return value & 1 << (bits - 1) ? value - (1 << bits) : value;
}

/* The index of a block's mode; -1: a reserved one. */
static inline int mode_of_block(const ty_bc6h_tables* tables, const uint8_t* block) {
    for (int m = 0; m < TY_BC6H_MODES; ++m) {
        const ty_bc6h_mode* mode = &tables->modes[m];
        if ((block[0] & ((1 << mode->number_bits) - 1)) == mode->number) return m;
    }
    return -1;
}

/* Decodes a block to 16 x 3 floats; returns its mode. */
static inline int decode_bc6h(const ty_bc6h_tables* tables, const uint8_t* block, bool with_sign, float out[16][3]) {
    const int number = mode_of_block(tables, block);
    const ty_bc6h_mode* mode = &tables->modes[number];
    int32_t at = mode->number_bits, ends[4][3] = {{0}}, partition = 0;
    for (int32_t i = 0; i < mode->places; ++i) {
        const int32_t field = mode->place[i] / 16;
        ends[field / 3][field % 3] |= take_bits(block, &at, 1) << (mode->place[i] % 16);
    }
    if (mode->subsets == 2) partition = take_bits(block, &at, 5);
    for (int e = 0; e < 2 * mode->subsets; ++e)
        for (int c = 0; c < 3; ++c) {
            if (e > 0 && (mode->transformed || with_sign)) ends[e][c] = extend_sign(ends[e][c], mode->delta[c]);
            if (e > 0 && mode->transformed) ends[e][c] = (ends[0][c] + ends[e][c]) & ((1 << mode->bits) - 1);
            if (with_sign && (e == 0 || mode->transformed)) ends[e][c] = extend_sign(ends[e][c], mode->bits);
        }
    const int32_t width = mode->subsets == 1 ? 4 : 3;
    for (int i = 0; i < 16; ++i) {
        const int subset = mode->subsets == 2 ? ty_bc6h_partitions[partition] >> i & 1 : 0;
        const bool anchor = i == 0 || (mode->subsets == 2 && i == ty_bc6h_anchors[partition]);
        const int32_t weight = ty_bc6h_weights[mode->subsets - 1][take_bits(block, &at, anchor ? width - 1 : width)];
        for (int c = 0; c < 3; ++c) {
            const int32_t a = ty_bc6h_unquantize(ends[2 * subset][c], mode->bits, with_sign);
            const int32_t b = ty_bc6h_unquantize(ends[2 * subset + 1][c], mode->bits, with_sign);
            const int32_t wide = (a * (64 - weight) + b * weight + 32) >> 6;
            const int32_t half = !with_sign ? wide * 31 >> 6 : wide < 0 ? 0x8000 | (-wide * 31 >> 5) : wide * 31 >> 5;
            out[i][c] = ty_half_to_float((uint16_t)half);
        }
    }
    return number;
}

#endif
