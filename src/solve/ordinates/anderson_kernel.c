/* Emission of the mixed iterate. Compiled once per instruction set, which TY_ISA names. */
#include "solve/ordinates/anderson_kernel.h"

#include "base/simd.h"

#include <string.h>

enum { TERMS_MAX = TY_SCATTERING_ORDER_MAX * TY_SCATTERING_ORDER_MAX };

/* Two iterates at a time: each pass over the output costs about as much as reading an iterate from memory. Not inlined:
 * within the outer loop compilers do not vectorise it. */
static __attribute__((noinline)) void set_weighted_sum(const float weights[2], const float* a, const float* b,
                                                       size_t count, float* to) {
#pragma omp simd
    for (size_t i = 0; i < count; ++i) to[i] = weights[0] * a[i] + weights[1] * b[i];
}

static __attribute__((noinline)) void add_weighted_sum(const float weights[2], const float* a, const float* b,
                                                       size_t count, float* to) {
#pragma omp simd
    for (size_t i = 0; i < count; ++i) to[i] += weights[0] * a[i] + weights[1] * b[i];
}

/* Weighted sum of `count` floats from `begin` of each iterate. An odd last iterate is paired with itself, weight 0. */
static void mix_iterates(const ty_anderson_iterate* m, const float* const* iterates, size_t begin, size_t count,
                         float* to) {
    if (m->count == 0) memset(to, 0, sizeof(float) * count);
    for (int32_t k = 0; k < m->count; k += 2) {
        const bool two = k + 1 < m->count;
        const float *a = iterates[k] + begin, *b = two ? iterates[k + 1] + begin : a;
        const float weights[2] = {m->anderson_weights[k], two ? m->anderson_weights[k + 1] : 0};
        (k == 0 ? set_weighted_sum : add_weighted_sum)(weights, a, b, count, to);
    }
}

/* Phase function moment per term: the caller's, or g^l - g^L. */
TY_INLINE void scattering_moments(const float* scattered, float g, const int32_t bands, float* weights) {
    float forward = 1, power = 1;
    for (int32_t l = 0; l < bands; ++l) forward *= g;
    for (int32_t l = 0; l < bands; ++l, power *= g)
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
            weights[t] = scattered != NULL ? scattered[l] : power - forward;
}

/* Scatters the mixed iterate of a cell in place. source_lm: NULL: no source. */
TY_INLINE void emit_cell(float scattering, const float* weights, const float* source_lm, const size_t terms,
                         float* emission) {
    if (source_lm != NULL) {
#pragma omp simd
        for (size_t t = 0; t < terms; ++t) emission[t] = scattering * weights[t] * emission[t] + source_lm[t];
    } else {
#pragma omp simd
        for (size_t t = 0; t < terms; ++t) emission[t] *= scattering * weights[t];
    }
}

/* Low-order moments come from their corrected arrays. */
TY_INLINE double emit_row(const ty_anderson_iterate* m, size_t begin, const int32_t bands) {
    const size_t cells = (size_t)m->cells, terms = (size_t)(bands * bands), low_order_terms = bands > 1 ? 4 : 1;
    float *low_order = m->mixed + begin * low_order_terms, weights[TERMS_MAX], g = m->g[begin];
    double sum = 0;
    scattering_moments(m->scattered, g, bands, weights);
    mix_iterates(m, m->low_order, begin * low_order_terms, cells * low_order_terms, low_order);
    mix_iterates(m, m->moments, begin * terms, cells * terms, m->emission + begin * terms);
    for (size_t x = 0; x < cells; ++x) {
        const size_t i = begin + x;
        const float scattering = m->scattering[i], *source_lm = m->source_lm != NULL ? m->source_lm + i * terms : NULL;
        float* emission = m->emission + i * terms;
        /* Most media have the same g all over a row. */
        if (m->g[i] != g) scattering_moments(m->scattered, g = m->g[i], bands, weights);
        emit_cell(scattering, weights, source_lm, terms, emission);
        for (size_t t = 0; t < low_order_terms; ++t)
            emission[t] = scattering * weights[t] * low_order[t * cells + x] + (source_lm != NULL ? source_lm[t] : 0);
        if (source_lm == NULL) emission[0] += m->source[i];
        /* Diffusive cells emit through their interfaces only. */
        if (m->diffusive != NULL && m->diffusive[i] >= 0) memset(emission, 0, sizeof *emission * terms);
        sum += (double)emission[0];
    }
    return sum;
}

static double emit(const ty_anderson_iterate* m, size_t begin) {
    switch (m->bands) {
    case 1: return emit_row(m, begin, 1);
    case 2: return emit_row(m, begin, 2);
    case 3: return emit_row(m, begin, 3);
    case 4: return emit_row(m, begin, 4);
    case 5: return emit_row(m, begin, 5);
    case 6: return emit_row(m, begin, 6);
    default: return emit_row(m, begin, m->bands);
    }
}

const ty_anderson_kernels TY_KERNEL_NAME(ty_anderson_kernels) = {.emit = emit};
