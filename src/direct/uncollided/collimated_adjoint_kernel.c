/* Row loops of the adjoint of parallel light, built once per instruction set, with TY_ISA naming it. */
#include "direct/uncollided/collimated_adjoint_kernel.h"

#include "direct/uncollided/point_light.k.h"

#include <string.h>

/* Blends three rows of cells, with two empty cells at either end. */
static void blend_cells(const ty_adjoint_rows* rows) {
    const float *a = rows->cells[0], *b = rows->cells[1], *c = rows->cells[2], *across = rows->across;
    float* blend = rows->blend;
    if (a != NULL && b != NULL && c != NULL) {
        blend[0] = blend[1] = blend[rows->count + 2] = blend[rows->count + 3] = 0.0f;
#pragma omp simd
        for (int32_t i = 0; i < rows->count; ++i) blend[i + 2] = ty_weighted_sum3(a[i], b[i], c[i], across);
        return;
    }
    memset(blend, 0, sizeof *blend * ((size_t)rows->count + 4));
    for (int32_t row = 0; row < 3; ++row) {
        const float *from = rows->cells[row], weight = across[row];
        if (from == NULL) continue;
#pragma omp simd
        for (int32_t i = 0; i < rows->count; ++i) blend[i + 2] += weight * from[i];
    }
}

static void pass(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes) {
    const float *blend = rows->blend, *along = rows->along, length = tubes->length;
    float* through = tubes->through;
    blend_cells(rows);
#pragma omp simd
    for (int32_t t = 0; t < rows->count + 2; ++t)
        through[t] *= ty_attenuation(ty_weighted_sum3(blend[t], blend[t + 1], blend[t + 2], along) * length);
}

static void note(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes) {
    const float *blend = rows->blend, *along = rows->along, length = tubes->length;
    float *before = tubes->before, *depth = tubes->depth, *through = tubes->through;
    blend_cells(rows);
#pragma omp simd
    for (int32_t t = 0; t < rows->count + 2; ++t) {
        const float x = ty_weighted_sum3(blend[t], blend[t + 1], blend[t + 2], along) * length;
        before[t] = through[t];
        depth[t] = x;
        through[t] = before[t] * ty_attenuation(x);
    }
}

static void begin(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes) {
    const float *before = tubes->before, *depth = tubes->depth;
    float *by_mean = tubes->by_mean, *mean = tubes->mean;
#pragma omp simd
    for (int32_t t = 0; t < rows->count + 2; ++t) {
        by_mean[t] = 0.0f;
        mean[t] = before[t] * ty_mean_attenuation(depth[t], ty_attenuation(depth[t]));
    }
}

static double weigh(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes, float color) {
    const float *blend = rows->blend, *along = rows->along, *mean = tubes->mean;
    float* by_mean = tubes->by_mean;
    float sum = 0;
    blend_cells(rows);
#pragma omp simd reduction(+ : sum)
    for (int32_t t = 0; t < rows->count + 2; ++t) {
        const float weight = color * ty_weighted_sum3(blend[t], blend[t + 1], blend[t + 2], along);
        by_mean[t] += weight;
        sum += weight * mean[t];
    }
    return (double)sum;
}

static void back(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes) {
    const float *before = tubes->before, *depth = tubes->depth, *by_mean = tubes->by_mean;
    float *through = tubes->through, *by_depth = tubes->by_depth;
#pragma omp simd
    for (int32_t t = 0; t < rows->count + 2; ++t) {
        const float x = depth[t], attenuation = ty_attenuation(x), m = ty_mean_attenuation(x, attenuation);
        const float behind = through[t];
        by_depth[t] = before[t] * (by_mean[t] * ty_mean_attenuation_slope(x, attenuation, m) - behind * attenuation);
        through[t] = by_mean[t] * m + behind * attenuation;
    }
}

static double back_of_one(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes, float color) {
    const float *blend = rows->blend, *along = rows->along, *before = tubes->before, *depth = tubes->depth;
    float *through = tubes->through, *by_depth = tubes->by_depth, *mean = tubes->mean;
    float sum = 0;
    blend_cells(rows);
#pragma omp simd reduction(+ : sum)
    for (int32_t t = 0; t < rows->count + 2; ++t) {
        const float x = depth[t], attenuation = ty_attenuation(x), m = ty_mean_attenuation(x, attenuation);
        const float weight = color * ty_weighted_sum3(blend[t], blend[t + 1], blend[t + 2], along);
        const float behind = through[t];
        mean[t] = before[t] * m;
        sum += weight * mean[t];
        by_depth[t] = before[t] * (weight * ty_mean_attenuation_slope(x, attenuation, m) - behind * attenuation);
        through[t] = weight * m + behind * attenuation;
    }
    return (double)sum;
}

static void gather(const ty_adjoint_rows* rows, float length, float* cells) {
    const float *first = rows->cells[0], *second = rows->cells[1], *third = rows->cells[2];
    const float *along = rows->along, *across = rows->across;
    float* blend = rows->blend;
#pragma omp simd
    for (int32_t t = 0; t < rows->count + 2; ++t) blend[t] = ty_weighted_sum3(first[t], second[t], third[t], across);
#pragma omp simd
    for (int32_t i = 0; i < rows->count; ++i)
        cells[i] += length * ty_weighted_sum3(blend[i + 2], blend[i + 1], blend[i], along);
}

const ty_collimated_adjoint_kernels TY_KERNEL_NAME(ty_collimated_adjoint_kernels) = {.pass = pass,
                                                                                     .note = note,
                                                                                     .back_of_one = back_of_one,
                                                                                     .begin = begin,
                                                                                     .weigh = weigh,
                                                                                     .back = back,
                                                                                     .gather = gather};
