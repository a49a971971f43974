/* Row loops over the items of beam.k.h; built once per instruction set, with TY_ISA naming it. */
#include "direct/kernel.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

/* Mean extinction of the three rows that tubes overlap, with two empty cells at either end. */
static void blend_rows(const ty_beam_row* row) {
    const int32_t count = row->count;
    const float *a = row->cells[0], *b = row->cells[1], *c = row->cells[2];
    const float* weight = row->weight[1];
    float* blend = row->blend;
    blend[0] = blend[1] = blend[count + 2] = blend[count + 3] = 0.0f;
#pragma omp simd
    for (int32_t i = 0; i < count; ++i) blend[i + 2] = ty_share_three(a[i], b[i], c[i], weight);
}

static void pass(const ty_beam_row* row) {
    const float *blend = row->blend, *in = row->in;
    float *out = row->out, *mean = row->mean;
    const float* weight = row->weight[0];
    const float length = row->length;
#pragma omp simd
    for (int32_t t = 0; t < row->count + 2; ++t) {
        const float depth = ty_share_three(blend[t], blend[t + 1], blend[t + 2], weight) * length;
        const float decay = ty_decay(depth);
        mean[t] = in[t] * ty_mean_decay(depth, decay);
        out[t] = in[t] * decay;
    }
}

/* The share of a slab that a ray is in before it meets a surface. */
TY_FN float open_share(float hit, float start, float per_length) {
    return ty_clampf((hit - start) * per_length, 0.0f, 1.0f);
}

/* Takes away what surfaces shade of each tube. */
static void shade(const ty_beam_row* row) {
    const float *a = row->hit[0], *b = row->hit[1], *c = row->hit[2], *d = row->hit[3];
    const float start = row->start, per_length = 1.0f / row->length;
    float* mean = row->mean;
#pragma omp simd
    for (int32_t t = 0; t < row->count + 2; ++t)
        mean[t] *= 0.25f * (open_share(a[t], start, per_length) + open_share(b[t], start, per_length) +
                            open_share(c[t], start, per_length) + open_share(d[t], start, per_length));
}

static void tubes(const ty_beam_row* row) {
    blend_rows(row);
    pass(row);
    if (row->hit[0] != NULL) shade(row);
}

static void cells(const ty_beam_cells* c) {
    const float *first = c->mean[0], *second = c->mean[1], *third = c->mean[2];
    const float *u = c->weight[0], *v = c->weight[1];
    float* lit = c->lit;
#pragma omp simd
    for (int32_t i = 0; i < c->count; ++i)
        lit[i] = ty_share_three(ty_share_three(first[i + 2], first[i + 1], first[i], u),
                                ty_share_three(second[i + 2], second[i + 1], second[i], u),
                                ty_share_three(third[i + 2], third[i + 1], third[i], u), v);
}

const ty_beam_kernels TY_JOIN(ty_beam_kernels_, TY_ISA) = {.tubes = tubes, .cells = cells};
