/* Row loops over the items of beam.k.h; built once per instruction set, with TY_ISA naming it. */
#include "direct/kernel.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

/* Extinction between the two rows that tubes overlap, with an empty cell at either end. */
static void blend_rows(const ty_beam_row* row) {
    const int32_t count = row->count;
    const float share = row->share[1];
    const float *first = row->first, *second = row->second;
    float* blend = row->blend;
    blend[0] = blend[count + 1] = 0.0f;
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) blend[i + 1] = ty_share_between(first[i], second[i], share);
}

static void pass_open(const ty_beam_row* row) {
    const float *blend = row->blend, *in = row->in;
    float *out = row->out, *mean = row->mean;
    const float share = row->share[0], length = row->length;
#pragma omp simd
    for (int32_t t = 0; t <= row->count; ++t) {
        const float depth = ty_share_between(blend[t], blend[t + 1], share) * length;
        const float decay = ty_decay(depth);
        mean[t] = in[t] * ty_mean_decay(depth, decay);
        out[t] = in[t] * decay;
    }
}

/* The same where surfaces end tubes. */
static void pass_shadowed(const ty_beam_row* row) {
    const float *blend = row->blend, *in = row->in, *hit = row->hit;
    float *out = row->out, *mean = row->mean;
    const float share = row->share[0], length = row->length, start = row->start;
    const float per_length = 1.0f / length;
#pragma omp simd
    for (int32_t t = 0; t <= row->count; ++t) {
        const float open = ty_clampf((hit[t] - start) * per_length, 0.0f, 1.0f);
        const float depth = ty_share_between(blend[t], blend[t + 1], share) * length * open;
        const float decay = ty_decay(depth);
        mean[t] = in[t] * ty_mean_decay(depth, decay) * open;
        out[t] = in[t] * decay;
    }
}

static void tubes(const ty_beam_row* row) {
    blend_rows(row);
    if (row->hit != NULL)
        pass_shadowed(row);
    else
        pass_open(row);
}

static void cells(const ty_beam_cells* c) {
    const float *first = c->first, *second = c->second;
    float* lit = c->lit;
    const float u = c->share[0], v = c->share[1];
#pragma omp simd
    for (int32_t i = 0; i < c->count; ++i)
        lit[i] = ty_share_between(ty_share_between(first[i + 1], first[i], u),
                                  ty_share_between(second[i + 1], second[i], u), v);
}

const ty_beam_kernels TY_JOIN(ty_beam_kernels_, TY_ISA) = {.tubes = tubes, .cells = cells};
