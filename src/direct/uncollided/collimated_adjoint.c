/* One pass along the tubes keeps what enters each of them in each slab; another one against the light gathers the
 * derivatives. In a slab with the optical depth x of a tube and the transmittance t before it,
 *
 *     mean = t m(x),   t' = t exp(-x),   m(x) = (1 - exp(-x)) / x,
 *
 * so that with mean* and t'* the derivatives of the loss by mean and by the transmittance behind the slab
 *
 *     x* = mean* t m'(x) - t'* t exp(-x),   t* = mean* m(x) + t'* exp(-x). */
#include "direct/uncollided/collimated_adjoint.h"

#include "base/context.h"
#include "base/parallel.h"
#include "direct/media/attenuation.k.h"
#include "direct/uncollided/collimated.h"

#include <string.h>

/* Tubes beyond either end of a row of cells that overlap it. */
enum { BORDER = 2 };

/* Smaller slabs are passed by one thread: waking others takes longer. */
enum { TUBES_FOR_THREADS = 1 << 12 };

typedef struct adjoint_job {
    const ty_collimated_loss* loss;
    const ty_collimated* beam;
    int32_t slab;          /* in the order of travel */
    int32_t width;         /* tubes that overlap a row of cells */
    int32_t rows;          /* rows of such tubes */
    ptrdiff_t step[3];     /* floats between cells along u, v, w */
    float *before, *depth; /* of each slab, row and tube: transmittance before the slab, optical depth within it */
    float* through;        /* transmittance of each tube, and then the loss's derivative by it */
    float* by_depth;       /* of the slab's tubes: the loss's derivative by depth */
    float* scratch;        /* of each worker, four rows of cells with borders */
    double (*sums)[3];     /* of each row of tubes: the loss per channel */
    float* gradient;
} adjoint_job;

static size_t tubes_of_slab(const adjoint_job* job) {
    return (size_t)job->width * (size_t)job->rows;
}

static ptrdiff_t slab_offset(const adjoint_job* job) {
    const ty_collimated* beam = job->beam;
    return job->step[2] * (beam->backwards ? beam->size[2] - 1 - job->slab : job->slab);
}

/* The tubes of a row of the slab among all tubes. */
static float* tubes_of_row(const adjoint_job* job, int64_t row) {
    const ty_collimated* beam = job->beam;
    const int32_t across = (int32_t)row - BORDER - beam->shift[1][job->slab] - beam->first[1];
    const int32_t along = -BORDER - beam->shift[0][job->slab] - beam->first[0];
    return job->through + (ptrdiff_t)across * beam->tubes[0] + along;
}

/* Weighted means of three rows of cells from row - BORDER on, with empty cells beyond the ends. */
static void blend_cells(const adjoint_job* job, const float* cells, int64_t row, float* out) {
    const ty_collimated* beam = job->beam;
    const float* weight = beam->weight[1][job->slab];
    const ptrdiff_t step = job->step[0];
    memset(out, 0, sizeof *out * ((size_t)beam->size[0] + 2 * BORDER));
    for (int32_t b = 0; b < 3; ++b) {
        const int64_t v = row - BORDER + b;
        if (v < 0 || v >= beam->size[1]) continue;
        const float* from = cells + slab_offset(job) + job->step[1] * (ptrdiff_t)v;
        for (int32_t i = 0; i < beam->size[0]; ++i) out[i + BORDER] += weight[b] * from[i * step];
    }
}

static float* scratch_of(const adjoint_job* job, int32_t worker) {
    return job->scratch + 4 * ((size_t)job->beam->size[0] + 2 * BORDER) * (size_t)worker;
}

static void pass_row(void* user, int64_t row, int32_t worker) {
    const adjoint_job* job = user;
    const float* weight = job->beam->weight[0][job->slab];
    const size_t at = tubes_of_slab(job) * (size_t)job->slab + (size_t)row * (size_t)job->width;
    float *blend = scratch_of(job, worker), *through = tubes_of_row(job, row);
    float *before = job->before + at, *depth = job->depth + at;
    blend_cells(job, job->loss->extinction, row, blend);
#pragma omp simd
    for (int32_t t = 0; t < job->width; ++t) {
        const float x = ty_weighted_sum3(blend[t], blend[t + 1], blend[t + 2], weight) * job->beam->length;
        before[t] = through[t];
        depth[t] = x;
        through[t] *= ty_attenuation(x);
    }
}

/* m'(x) = (exp(-x) - m(x)) / x, and its series where that loses digits. */
TY_FN float mean_attenuation_slope(float x, float attenuation, float mean) {
    const float series = -0.5f + x * (1.0f / 3.0f - x * (0.125f - x * (1.0f / 30.0f)));
    return x < 0.1f ? series : (attenuation - mean) / ty_maxf(x, 0.1f);
}

static void return_row(void* user, int64_t row, int32_t worker) {
    const adjoint_job* job = user;
    const ty_collimated_loss* loss = job->loss;
    const float* weight = job->beam->weight[0][job->slab];
    const size_t in_slab = (size_t)row * (size_t)job->width, at = tubes_of_slab(job) * (size_t)job->slab + in_slab;
    const size_t width = (size_t)job->beam->size[0] + 2 * BORDER;
    const float *before = job->before + at, *depth = job->depth + at;
    float *blend = scratch_of(job, worker), *by_mean = blend + width, *mean = blend + 2 * width;
    float *behind = tubes_of_row(job, row), *by_depth = job->by_depth + in_slab;
    memset(by_mean, 0, sizeof *by_mean * width);
    for (int32_t t = 0; t < job->width; ++t)
        mean[t] = before[t] * ty_mean_attenuation(depth[t], ty_attenuation(depth[t]));
    for (int32_t c = 0; c < loss->channels; ++c) {
        double sum = 0;
        blend_cells(job, loss->weight[c], row, blend);
        for (int32_t t = 0; t < job->width; ++t) {
            const float by_channel = loss->color[c] * ty_weighted_sum3(blend[t], blend[t + 1], blend[t + 2], weight);
            by_mean[t] += by_channel;
            sum += (double)(by_channel * mean[t]);
        }
        job->sums[row][c] += sum;
    }
#pragma omp simd
    for (int32_t t = 0; t < job->width; ++t) {
        const float attenuation = ty_attenuation(depth[t]), m = ty_mean_attenuation(depth[t], attenuation);
        by_depth[t] =
            before[t] * (by_mean[t] * mean_attenuation_slope(depth[t], attenuation, m) - behind[t] * attenuation);
        behind[t] = by_mean[t] * m + behind[t] * attenuation;
    }
}

/* Adds the derivatives by depth of the nine tubes that overlap each cell of a row. */
static void gather_row(void* user, int64_t v, int32_t worker) {
    const adjoint_job* job = user;
    const ty_collimated* beam = job->beam;
    const float *along = beam->weight[0][job->slab], *across = beam->weight[1][job->slab];
    const ptrdiff_t step = job->step[0];
    float *sum = scratch_of(job, worker), *out = job->gradient + slab_offset(job) + job->step[1] * (ptrdiff_t)v;
    memset(sum, 0, sizeof *sum * (size_t)job->width);
    for (int64_t b = 0; b < 3; ++b) {
        const float* from = job->by_depth + (v + BORDER - b) * job->width;
        for (int32_t t = 0; t < job->width; ++t) sum[t] += across[b] * from[t];
    }
    for (int32_t i = 0; i < beam->size[0]; ++i)
        out[i * step] += beam->length * ty_weighted_sum3(sum[i + 2], sum[i + 1], sum[i], along);
}

static void pass_all(adjoint_job* job) {
    ty_context* context = tubes_of_slab(job) >= TUBES_FOR_THREADS ? job->beam->context : NULL;
    const size_t tubes = ty_collimated_tubes(job->beam);
    for (size_t t = 0; t < tubes; ++t) job->through[t] = 1;
    for (job->slab = 0; job->slab < job->beam->size[2]; ++job->slab)
        ty_parallel_flushed(context, job->rows, pass_row, job);
    memset(job->through, 0, sizeof *job->through * tubes);
    for (job->slab = job->beam->size[2] - 1; job->slab >= 0; --job->slab) {
        ty_parallel_flushed(context, job->rows, return_row, job);
        ty_parallel_flushed(context, job->beam->size[1], gather_row, job);
    }
}

static ty_result run(adjoint_job* job, double strength[3]) {
    ty_context* context = job->beam->context;
    const size_t tubes = tubes_of_slab(job), slabs = (size_t)job->beam->size[2], rows = (size_t)job->rows;
    const size_t row = (size_t)job->beam->size[0] + 2 * BORDER, threads = (size_t)ty_context_threads(context);
    job->before = ty_alloc_array(context, tubes * slabs, sizeof(float), false);
    job->depth = ty_alloc_array(context, tubes * slabs, sizeof(float), false);
    job->through = ty_alloc_array(context, ty_collimated_tubes(job->beam), sizeof(float), false);
    job->by_depth = ty_alloc_array(context, tubes, sizeof(float), false);
    job->scratch = ty_alloc_array(context, 4 * row * threads, sizeof(float), false);
    job->sums = ty_alloc_array(context, rows, sizeof *job->sums, true);
    const bool whole = job->before != NULL && job->depth != NULL && job->through != NULL && job->by_depth != NULL &&
                       job->scratch != NULL && job->sums != NULL;
    if (whole) pass_all(job);
    for (int c = 0; c < 3; ++c) strength[c] = 0;
    for (size_t r = 0; r < rows && whole; ++r)
        for (int c = 0; c < 3; ++c) strength[c] += job->sums[r][c];
    ty_free_array(context, job->before, tubes * slabs, sizeof(float));
    ty_free_array(context, job->depth, tubes * slabs, sizeof(float));
    ty_free_array(context, job->through, ty_collimated_tubes(job->beam), sizeof(float));
    ty_free_array(context, job->by_depth, tubes, sizeof(float));
    ty_free_array(context, job->scratch, 4 * row * threads, sizeof(float));
    ty_free_array(context, job->sums, rows, sizeof *job->sums);
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_collimated_adjoint(const ty_grid_medium* medium, const ty_collimated_loss* loss, float* gradient,
                                double strength[3]) {
    static const ty_scene_view without_surfaces;
    const double outside[2][3] = {{0}};
    ty_collimated beam;
    adjoint_job job = {.loss = loss, .beam = &beam, .gradient = gradient};
    ty_result result = ty_collimated_begin(&without_surfaces, medium, outside, loss->source->direction, &beam);
    if (result == TY_OK) {
        const ptrdiff_t steps[3] = {1, medium->box.size[0], (ptrdiff_t)medium->box.size[0] * medium->box.size[1]};
        for (int i = 0; i < 3; ++i) job.step[i] = steps[beam.axis[i]];
        job.width = beam.size[0] + BORDER;
        job.rows = beam.size[1] + BORDER;
        result = run(&job, strength);
    }
    ty_collimated_end(&beam);
    return result;
}
