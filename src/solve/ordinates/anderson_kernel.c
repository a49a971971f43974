/* What a sweep emits. Built once per instruction set, with TY_ISA naming it. */
#include "solve/ordinates/anderson_kernel.h"

#include <string.h>

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)
/* What is inlined where the number of bands is known, so that loops over terms have no ends to look for. */
#define TY_INLINE static inline __attribute__((always_inline))

enum { TERMS_MAX = TY_SCATTERING_ORDER_MAX * TY_SCATTERING_ORDER_MAX };

/* Shares of two at a time: each pass over what is there already costs about as much as reading one from memory. Not
 * inlined: of the loop around it, compilers make one over single floats. */
static __attribute__((noinline)) void set_shares(const float share[2], const float* a, const float* b, size_t count,
                                                 float* to) {
#pragma omp simd
    for (size_t i = 0; i < count; ++i) to[i] = share[0] * a[i] + share[1] * b[i];
}

static __attribute__((noinline)) void add_shares(const float share[2], const float* a, const float* b, size_t count,
                                                 float* to) {
#pragma omp simd
    for (size_t i = 0; i < count; ++i) to[i] += share[0] * a[i] + share[1] * b[i];
}

/* `count` floats from `begin` on, of each iterate. Of an odd number the last is there once more, with no share. */
static void mix(const ty_anderson_iterate* m, const float* const* iterates, size_t begin, size_t count, float* to) {
    if (m->count == 0) memset(to, 0, sizeof(float) * count);
    for (int32_t k = 0; k < m->count; k += 2) {
        const bool two = k + 1 < m->count;
        const float *a = iterates[k] + begin, *b = two ? iterates[k + 1] + begin : a;
        const float share[2] = {m->shares[k], two ? m->shares[k + 1] : 0};
        (k == 0 ? set_shares : add_shares)(share, a, b, count, to);
    }
}

/* Of each term, what the caller has, or g^l - g^L. */
TY_INLINE void turn(const float* scattered, float g, const int32_t bands, float* share) {
    float forward = 1, power = 1;
    for (int32_t l = 0; l < bands; ++l) forward *= g;
    for (int32_t l = 0; l < bands; ++l, power *= g)
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
            share[t] = scattered != NULL ? scattered[l] : power - forward;
}

/* Makes of a cell's mixture what it emits. fixed: NULL: nothing is added. */
TY_INLINE void emit_cell(float scattering, const float* share, const float* fixed, const size_t terms,
                         float* emission) {
    if (fixed != NULL) {
#pragma omp simd
        for (size_t t = 0; t < terms; ++t) emission[t] = scattering * share[t] * emission[t] + fixed[t];
    } else {
#pragma omp simd
        for (size_t t = 0; t < terms; ++t) emission[t] *= scattering * share[t];
    }
}

/* Low terms of mixtures come from where they are corrected. */
TY_INLINE double emit_row(const ty_anderson_iterate* m, size_t begin, const int32_t bands) {
    const size_t cells = (size_t)m->cells, terms = (size_t)(bands * bands), lows = bands > 1 ? 4 : 1;
    float *low = m->before + begin * lows, share[TERMS_MAX], g = m->g[begin];
    double sum = 0;
    turn(m->scattered, g, bands, share);
    mix(m, m->low, begin * lows, cells * lows, low);
    mix(m, m->moments, begin * terms, cells * terms, m->emission + begin * terms);
    for (size_t x = 0; x < cells; ++x) {
        const size_t i = begin + x;
        const float scattering = m->scattering[i], *fixed = m->fixed != NULL ? m->fixed + i * terms : NULL;
        float* emission = m->emission + i * terms;
        /* Most media have the same g all over a row. */
        if (m->g[i] != g) turn(m->scattered, g = m->g[i], bands, share);
        emit_cell(scattering, share, fixed, terms, emission);
        for (size_t t = 0; t < lows; ++t)
            emission[t] = scattering * share[t] * low[t * cells + x] + (fixed != NULL ? fixed[t] : 0);
        if (fixed == NULL) emission[0] += m->source[i];
        /* Thick cells send what their skins do. */
        if (m->thick != NULL && m->thick[i] >= 0) memset(emission, 0, sizeof *emission * terms);
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

const ty_anderson_kernels TY_JOIN(ty_anderson_kernels_, TY_ISA) = {.emit = emit};
