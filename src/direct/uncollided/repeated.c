#include "direct/uncollided/repeated.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "base/parallel.h"
#include "direct/media/attenuation.k.h"
#include "direct/uncollided/collimated.h"

#include <math.h>
#include <string.h>

/* Layers with fewer cells are swept by one thread: waking others takes longer. */
enum { CELLS_FOR_THREADS = 1 << 12 };
/* Light that crosses more cells than this in one layer is as good as parallel to it. */
static const double MAX_SLOPE = 65536;

/* A part of a layer in which tubes move by at most one cell along u and v. */
typedef struct repeated_job {
    const ty_grid_medium* medium;
    const ty_repeated_beam* beam;
    int32_t axis[3], size[3]; /* u, v and w */
    size_t stride[3];
    float *along, *spread; /* per tube: transmittance; and its mean within this part, spread over the cells of a row */
    float* scratch;        /* of each worker */
    size_t first;          /* of the layer's cells */
    int32_t shift[2];      /* tube t covers cells t + shift and the next two, modulo the size */
    float weight[2][3];
    float length; /* path length, m */
    float part;   /* of the layer's path */
} repeated_job;

int32_t ty_repeated_axis(const ty_grid_medium* medium) {
    for (int32_t a = 0; a < 3; ++a)
        if ((medium->periodic >> a & 1) == 0) return a;
    return 2;
}

static int32_t modulo(int64_t index, int32_t size) {
    const int64_t rest = index % size;
    return (int32_t)(rest < 0 ? rest + size : rest);
}

/* A row of tubes over three rows of cells. */
static void pass_row(void* user, int64_t row, int32_t worker) {
    const repeated_job* job = user;
    const int32_t nu = job->size[0], nv = job->size[1], begin = modulo(job->shift[0], nu);
    float *blend = job->scratch + (size_t)worker * 2 * ((size_t)nu + 2), *mean = blend + nu + 2;
    const float* rows[3];
    for (int i = 0; i < 3; ++i)
        rows[i] = job->beam->extinction + job->first + job->stride[1] * (size_t)modulo(row + job->shift[1] + i, nv);
    for (int32_t k = 0, u = begin; k < nu + 2; ++k, u = u + 1 == nu ? 0 : u + 1) {
        const size_t at = job->stride[0] * (size_t)u;
        blend[k] = ty_weighted_sum3(rows[0][at], rows[1][at], rows[2][at], job->weight[1]);
    }
    float* along = job->along + (size_t)row * (size_t)nu;
#pragma omp simd
    for (int32_t t = 0; t < nu; ++t) {
        const float depth = ty_weighted_sum3(blend[t], blend[t + 1], blend[t + 2], job->weight[0]) * job->length;
        const float attenuation = ty_attenuation(depth);
        mean[t + 2] = along[t] * ty_mean_attenuation(depth, attenuation) * job->part;
        along[t] *= attenuation;
    }
    for (int i = 0; i < 2; ++i) mean[i] = mean[modulo(i - 2, nu) + 2];
    float* spread = job->spread + (size_t)row * (size_t)nu;
    for (int32_t k = 0, u = begin; k < nu; ++k, u = u + 1 == nu ? 0 : u + 1)
        spread[u] = ty_weighted_sum3(mean[k + 2], mean[k + 1], mean[k], job->weight[0]);
}

/* A row of cells from three rows of tubes. */
static void fill_row(void* user, int64_t v, int32_t worker) {
    (void)worker;
    const repeated_job* job = user;
    const int32_t nu = job->size[0], nv = job->size[1];
    const float* rows[3];
    for (int i = 0; i < 3; ++i) rows[i] = job->spread + (size_t)nu * (size_t)modulo(v - job->shift[1] - i, nv);
    for (int32_t p = 0; p < job->beam->plane_count; ++p) {
        float* plane = job->beam->planes[p] + job->first + job->stride[1] * (size_t)v;
        const float factor = job->beam->factor[p];
        for (int32_t u = 0; u < nu; ++u)
            plane[job->stride[0] * (size_t)u] +=
                factor * ty_weighted_sum3(rows[0][u], rows[1][u], rows[2][u], job->weight[1]);
    }
}

/* Sets shifts and weights for tubes that move from one position to another, cells. */
static void place_tubes(repeated_job* job, const double from[2], const double to[2]) {
    for (int i = 0; i < 2; ++i) {
        const double whole = floor(fmin(from[i], to[i]));
        job->shift[i] = (int32_t)whole;
        for (int cell = 0; cell < 3; ++cell)
            job->weight[i][cell] = (float)ty_tube_overlap(whole + cell, from[i], to[i]);
        job->weight[i][1] = 1 - job->weight[i][0] - job->weight[i][2];
    }
}

/* The mean transmittance over the faces of a layer, by their overlap with the tubes there. */
static void store_through(repeated_job* job, const double at[2], double cosine, double* out) {
    place_tubes(job, at, at);
    for (int32_t v = 0; v < job->size[1]; ++v)
        for (int32_t u = 0; u < job->size[0]; ++u) {
            double sum = 0;
            for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 3; ++i) {
                    const int32_t row = modulo(v - job->shift[1] - j, job->size[1]),
                                  tube = modulo(u - job->shift[0] - i, job->size[0]);
                    sum += (double)(job->weight[0][i] * job->weight[1][j]) *
                           (double)job->along[(size_t)row * (size_t)job->size[0] + (size_t)tube];
                }
            out[(size_t)v * (size_t)job->size[0] + (size_t)u] = cosine * sum;
        }
}

static void pass_layers(repeated_job* job) {
    const ty_grid_medium* medium = job->medium;
    const ty_repeated_beam* beam = job->beam;
    const double omega[3] = {(double)beam->direction.x, (double)beam->direction.y, (double)beam->direction.z};
    const double length = sqrt(omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2]);
    const int32_t w = job->axis[2], nw = job->size[2];
    const double cosine = omega[w] / length, path = medium->cell[w] / fabs(cosine);
    double slope[2], at[2] = {0, 0};
    for (int i = 0; i < 2; ++i) slope[i] = omega[job->axis[i]] / length * path / medium->cell[job->axis[i]];
    const double steepest = fmax(fabs(slope[0]), fabs(slope[1]));
    const size_t faces = (size_t)job->size[0] * (size_t)job->size[1];
    const bool backwards = cosine < 0;
    if (!(steepest < MAX_SLOPE)) return;
    const int32_t parts = steepest > 1 ? (int32_t)ceil(steepest) : 1;
    job->length = (float)(path / parts);
    job->part = 1.0f / (float)parts;
    ty_context* context = faces >= CELLS_FOR_THREADS ? medium->context : NULL;
    if (beam->through != NULL) store_through(job, at, fabs(cosine), beam->through + (backwards ? nw : 0) * faces);
    for (int32_t layer = 0; layer < nw; ++layer) {
        const int32_t index = backwards ? nw - 1 - layer : layer;
        job->first = job->stride[2] * (size_t)index;
        for (int32_t part = 0; part < parts; ++part) {
            const double from[2] = {at[0], at[1]}, step = layer + (double)(part + 1) / parts;
            for (int i = 0; i < 2; ++i) at[i] = slope[i] * step;
            place_tubes(job, from, at);
            ty_parallel_flushed(context, job->size[1], pass_row, job);
            ty_parallel_flushed(context, job->size[1], fill_row, job);
        }
        if (beam->through != NULL)
            store_through(job, at, fabs(cosine), beam->through + (size_t)(backwards ? index : index + 1) * faces);
    }
}

ty_result ty_repeated_sweep(const ty_grid_medium* medium, const ty_repeated_beam* beam) {
    ty_context* context = medium->context;
    const int32_t w = ty_repeated_axis(medium), threads = ty_context_threads(context);
    repeated_job job = {.medium = medium, .beam = beam, .axis = {w == 0 ? 1 : 0, w == 2 ? 1 : 2, w}};
    const size_t strides[3] = {1, (size_t)medium->box.size[0],
                               (size_t)medium->box.size[0] * (size_t)medium->box.size[1]};
    for (int i = 0; i < 3; ++i) {
        job.size[i] = medium->box.size[job.axis[i]];
        job.stride[i] = strides[job.axis[i]];
    }
    const size_t tubes = (size_t)job.size[0] * (size_t)job.size[1];
    const size_t scratch = 2 * ((size_t)job.size[0] + 2) * (size_t)threads;
    job.along = ty_alloc_array(context, tubes, sizeof(float), false);
    job.spread = ty_alloc_array(context, tubes, sizeof(float), false);
    job.scratch = ty_alloc_array(context, scratch, sizeof(float), false);
    const bool whole = job.along != NULL && job.spread != NULL && job.scratch != NULL;
    for (size_t t = 0; t < tubes && whole; ++t) job.along[t] = 1;
    if (whole) pass_layers(&job);
    ty_free_array(context, job.along, tubes, sizeof(float));
    ty_free_array(context, job.spread, tubes, sizeof(float));
    ty_free_array(context, job.scratch, scratch, sizeof(float));
    return whole ? TY_OK : TY_ERROR_MEMORY;
}
