/* Overlap-weighted means of cells over other cells of the same box. */
#include "base/float_mode.h"
#include "direct/media/grid_medium.h"

#include <math.h>
#include <string.h>

typedef struct average_job {
    const float *from, *weight; /* weight: NULL: 1 */
    float *to, *weighted;       /* either may be NULL */
    int32_t from_size[3], to_size[3];
} average_job;

/* The range of source cells that a target cell covers, and the target's bounds. */
typedef struct overlap {
    int32_t begin, end;
    double lower, upper, scale; /* target cell in source cells; target cells per source cell */
} overlap;

static overlap overlap_of(int32_t index, int32_t from, int32_t to) {
    overlap o;
    o.scale = (double)to / from;
    o.lower = (double)index * from / to;
    o.upper = (double)(index + 1) * from / to;
    o.begin = (int32_t)floor(o.lower);
    o.end = (int32_t)ceil(o.upper);
    if (o.end > from) o.end = from;
    return o;
}

/* The fraction of the target cell that source cell `at` covers. */
static double weight_of(const overlap* o, int32_t at) {
    const double lower = at < o->lower ? o->lower : at, upper = at + 1 > o->upper ? o->upper : at + 1;
    return (upper - lower) * o->scale;
}

/* Source cells of a row that are averaged across rows at a time. */
enum { BLOCK = 1024 };

/* Means over the rows that y and z cover, for a block of source cells from x on. */
typedef struct block_means {
    double plain[BLOCK], weighted[BLOCK];
} block_means;

static void mean_across(const average_job* job, const overlap* y, const overlap* z, int32_t x, int32_t count,
                        block_means* sum) {
    const int32_t* size = job->from_size;
    memset(sum->plain, 0, sizeof *sum->plain * (size_t)count);
    memset(sum->weighted, 0, sizeof *sum->weighted * (size_t)count);
    for (int32_t k = z->begin; k < z->end; ++k)
        for (int32_t j = y->begin; j < y->end; ++j) {
            const size_t at = (size_t)size[0] * ((size_t)j + (size_t)size[1] * (size_t)k) + (size_t)x;
            const float *row = job->from + at, *weight = job->weight != NULL ? job->weight + at : NULL;
            const double weight_yz = weight_of(y, j) * weight_of(z, k);
#pragma omp simd
            for (int32_t i = 0; i < count; ++i) sum->plain[i] += weight_yz * (double)row[i];
            if (weight == NULL) continue;
#pragma omp simd
            for (int32_t i = 0; i < count; ++i) sum->weighted[i] += weight_yz * (double)(weight[i] * row[i]);
        }
}

/* Adds a block's contribution to the target cells that it overlaps; `to` is the first target cell of the row. */
static void add_along(const average_job* job, int32_t x, int32_t count, const double sum[BLOCK], float* to) {
    const int32_t from_size = job->from_size[0], to_size = job->to_size[0];
    const int32_t times = from_size % to_size == 0 && x == 0 && count == from_size ? from_size / to_size : 0;
    for (int32_t i = 0; i < to_size && times > 0; ++i) {
        double all = 0;
        for (int32_t n = 0; n < times; ++n) all += sum[times * i + n];
        to[i] += (float)(all / times);
    }
    for (int32_t i = (int32_t)((int64_t)x * to_size / from_size); i < to_size && times == 0; ++i) {
        const overlap o = overlap_of(i, from_size, to_size);
        const int32_t begin = o.begin > x ? o.begin : x, end = o.end < x + count ? o.end : x + count;
        if (begin >= x + count) return;
        double mean = 0;
        for (int32_t at = begin; at < end; ++at) mean += weight_of(&o, at) * sum[at - x];
        to[i] += (float)mean;
    }
}

static void average_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const average_job* job = user;
    const int32_t from = job->from_size[0];
    const overlap y = overlap_of((int32_t)(index % job->to_size[1]), job->from_size[1], job->to_size[1]);
    const overlap z = overlap_of((int32_t)(index / job->to_size[1]), job->from_size[2], job->to_size[2]);
    const unsigned state = ty_flush_denormals();
    float* to[2] = {job->to, job->weighted};
    for (int i = 0; i < 2; ++i) {
        if (to[i] == NULL) continue;
        to[i] += index * job->to_size[0];
        memset(to[i], 0, sizeof *to[i] * (size_t)job->to_size[0]);
    }
    for (int32_t x = 0; x < from; x += BLOCK) {
        block_means sum;
        const int32_t count = from - x < BLOCK ? from - x : BLOCK;
        mean_across(job, &y, &z, x, count, &sum);
        if (to[0] != NULL) add_along(job, x, count, sum.plain, to[0]);
        if (to[1] != NULL) add_along(job, x, count, sum.weighted, to[1]);
    }
    ty_restore_denormals(state);
}

static void run(ty_context* context, average_job* job, const int32_t from_size[3], const int32_t to_size[3]) {
    memcpy(job->from_size, from_size, sizeof job->from_size);
    memcpy(job->to_size, to_size, sizeof job->to_size);
    ty_parallel_for(context, (int64_t)to_size[1] * to_size[2], average_row, job);
}

void ty_grid_average_both(ty_context* context, const float* from, const float* weight, const int32_t from_size[3],
                          const int32_t to_size[3], float* weighted, float* plain) {
    average_job job = {.from = from, .weight = weight, .to = plain, .weighted = weighted};
    run(context, &job, from_size, to_size);
}

void ty_grid_average(ty_context* context, const float* from, const int32_t from_size[3], const int32_t to_size[3],
                     float* to) {
    average_job job = {.from = from, .to = to};
    run(context, &job, from_size, to_size);
}

/* ---- the transpose ---- */

/* The range of coarser cells that a finer cell is part of. */
static overlap parts_of(int32_t index, int32_t from, int32_t to) {
    overlap o = overlap_of(index, from, to);
    if (o.begin >= from) o.begin = from - 1;
    return o;
}

/* The part of coarser cell `at` that the finer cell `index` is, of `from` coarser and `to` finer cells. */
static double part_of(int32_t index, int32_t from, int32_t to, int32_t at) {
    const overlap coarse = overlap_of(at, to, from);
    return fmax(0, weight_of(&coarse, index));
}

/* The coarser cells that a column of finer cells is part of, two at most where they are coarser. */
typedef struct column_parts {
    int32_t at[2];
    float weight[2];
} column_parts;

/* Columns of a row that are spread to at a time. */
enum { COLUMNS = 512 };

typedef struct spread_job {
    const float* from;
    float* to;
    const int32_t *from_size, *to_size;
    int32_t first, count;        /* columns */
    column_parts parts[COLUMNS]; /* where the cells of `from` are coarser along x */
} spread_job;

static void find_columns(spread_job* job) {
    const int32_t from = job->from_size[0], to = job->to_size[0];
    for (int32_t x = 0; x < job->count && from <= to; ++x) {
        const overlap columns = parts_of(job->first + x, from, to);
        for (int32_t n = 0; n < 2; ++n) {
            const int32_t at = columns.begin + n;
            job->parts[x].at[n] = at < columns.end ? at : columns.begin;
            job->parts[x].weight[n] = at < columns.end ? (float)part_of(job->first + x, from, to, at) : 0;
        }
    }
}

/* Adds a row of coarser cells times weight. */
static void spread_along(const spread_job* job, float weight, const float* row, float* out) {
    const int32_t from = job->from_size[0], to = job->to_size[0];
    if (from <= to) {
        for (int32_t x = 0; x < job->count; ++x) {
            const column_parts* parts = &job->parts[x];
            out[x] += weight * (parts->weight[0] * row[parts->at[0]] + parts->weight[1] * row[parts->at[1]]);
        }
        return;
    }
    for (int32_t x = 0; x < job->count; ++x) {
        const overlap columns = parts_of(job->first + x, from, to);
        for (int32_t i = columns.begin; i < columns.end; ++i)
            out[x] += weight * (float)part_of(job->first + x, from, to, i) * row[i];
    }
}

static void spread_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const spread_job* job = user;
    const int32_t *from = job->from_size, *to = job->to_size;
    const int32_t y = (int32_t)(index % to[1]), z = (int32_t)(index / to[1]);
    const overlap rows = parts_of(y, from[1], to[1]), layers = parts_of(z, from[2], to[2]);
    for (int32_t k = layers.begin; k < layers.end; ++k)
        for (int32_t j = rows.begin; j < rows.end; ++j) {
            const double weight = part_of(z, from[2], to[2], k) * part_of(y, from[1], to[1], j);
            if (weight > 0)
                spread_along(job, (float)weight,
                             job->from + (size_t)from[0] * ((size_t)j + (size_t)from[1] * (size_t)k),
                             job->to + index * to[0] + job->first);
        }
}

void ty_grid_spread(ty_context* context, const float* from, const int32_t from_size[3], const int32_t to_size[3],
                    float* to) {
    spread_job job = {.from = from, .to = to, .from_size = from_size, .to_size = to_size};
    for (; job.first < to_size[0]; job.first += COLUMNS) {
        job.count = to_size[0] - job.first < COLUMNS ? to_size[0] - job.first : COLUMNS;
        find_columns(&job);
        ty_parallel_for(context, (int64_t)to_size[1] * to_size[2], spread_row, &job);
    }
}
