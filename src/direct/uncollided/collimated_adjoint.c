/* One pass along the tubes keeps what enters each of them in the first of every few slabs. Against the light these
 * slabs are passed once more, a block at a time that stays in the cache, and the derivatives gathered. In a slab with
 * the optical depth x of a tube and the transmittance t before it,
 *
 *     mean = t m(x),   t' = t exp(-x),   m(x) = (1 - exp(-x)) / x,
 *
 * so that with mean* and t'* the derivatives of the loss by mean and by the transmittance behind the slab
 *
 *     x* = mean* t m'(x) - t'* t exp(-x),   t* = mean* m(x) + t'* exp(-x). */
#include "direct/uncollided/collimated_adjoint.h"

#include "base/context.h"
#include "base/parallel.h"
#include "direct/uncollided/collimated.h"
#include "direct/uncollided/collimated_adjoint_kernel.h"

#include <string.h>

/* Tubes beyond either end of a row of cells that overlap it; rows of scratch per worker. */
enum { BORDER = 2, SCRATCH_ROWS = 2 };

/* Slabs of a block; directions that go through a block one after another. */
enum { BLOCK = 8, TOGETHER = 8 };

/* Smaller slabs are passed by one thread: waking others takes longer. */
enum { TUBES_FOR_THREADS = 1 << 12 };

float ty_uncollided_loss_color(const ty_uncollided_loss* loss, const ty_discrete_light* source, int32_t channel) {
    const float *color = source->color, *multiples = loss->multiples;
    if (multiples == NULL) return color[loss->first + channel];
    return multiples[0] * color[0] + multiples[1] * color[1] + multiples[2] * color[2];
}

void ty_uncollided_loss_add(const ty_uncollided_loss* loss, const ty_discrete_light* source, int32_t channel,
                            double part, double strength[3]) {
    const float *multiples = loss->multiples, all = ty_uncollided_loss_color(loss, source, channel);
    if (multiples == NULL) strength[loss->first + channel] += part;
    for (int c = 0; c < 3 && multiples != NULL && all != 0; ++c)
        strength[c] += part * (double)(multiples[c] * source->color[c] / all);
}

/* Planes of cells in the order in which rows are along u: the medium's own, or with x and z exchanged. */
typedef struct cell_planes {
    const float *extinction, *weight[3];
    float *gradient, *transmittance; /* transmittance: NULL: not asked for */
} cell_planes;

/* A direction on its way. */
typedef struct passage {
    ty_collimated beam;
    const ty_discrete_light* source;
    float* through;    /* of each tube: transmittance, and on the way back the loss's derivative by it */
    float* begun;      /* of each block, row and tube: transmittance before its first slab */
    double (*sums)[3]; /* of each row of tubes: the loss per channel */
} passage;

typedef struct adjoint_job {
    const ty_grid_medium* medium;
    const ty_uncollided_loss* loss;
    const ty_collimated_adjoint_kernels* kernels;
    const passage* at;
    const ty_collimated* beam; /* of the passage */
    const cell_planes* planes;
    int32_t slab;          /* in the order of travel */
    int32_t width, rows;   /* tubes that overlap a row of cells, and rows of such tubes */
    float* through;        /* transmittance of each tube, or the loss's derivative by it */
    float* light;          /* transmittance of each tube on the way through a block */
    float *before, *depth; /* of each slab of a block, row and tube: transmittance before the slab, optical depth */
    float* by_depth;       /* of the slab's tubes: the loss's derivative by depth */
    float* mean;           /* of the slab's tubes: mean transmittance */
    float* scratch;        /* of each worker */
    ty_collimated_scratch* memory; /* of all of these */
} adjoint_job;

static size_t tubes_of_slab(const adjoint_job* job) {
    return (size_t)job->width * (size_t)job->rows;
}

static size_t scratch_row(const adjoint_job* job) {
    return (size_t)job->beam->size[0] + 2 * BORDER;
}

/* Row v of cells in the slab; NULL beyond the box. */
static const float* cell_row(const adjoint_job* job, const float* cells, int64_t v) {
    const ty_collimated* beam = job->beam;
    const int32_t slab = beam->backwards ? beam->size[2] - 1 - job->slab : job->slab;
    if (v < 0 || v >= beam->size[1]) return NULL;
    return cells + beam->stride[2] * (size_t)slab + beam->stride[1] * (size_t)v;
}

/* The three rows of cells that a row of tubes overlaps. */
static ty_adjoint_rows rows_of(const adjoint_job* job, const float* cells, int64_t row, int32_t worker) {
    ty_adjoint_rows rows = {.count = job->beam->size[0],
                            .across = job->beam->weight[1][job->slab],
                            .along = job->beam->weight[0][job->slab],
                            .blend = job->scratch + SCRATCH_ROWS * scratch_row(job) * (size_t)worker};
    for (int32_t b = 0; b < 3; ++b) rows.cells[b] = cell_row(job, cells, row - BORDER + b);
    return rows;
}

static ty_adjoint_tubes tubes_of(const adjoint_job* job, int64_t row, const ty_adjoint_rows* rows) {
    const ty_collimated* beam = job->beam;
    const int32_t across = (int32_t)row - BORDER - beam->shift[1][job->slab] - beam->first[1];
    const int32_t along = -BORDER - beam->shift[0][job->slab] - beam->first[0];
    const size_t in_slab = (size_t)row * (size_t)job->width;
    const size_t at = tubes_of_slab(job) * (size_t)(job->slab % BLOCK) + in_slab;
    return (ty_adjoint_tubes){.length = beam->length,
                              .before = job->before + at,
                              .depth = job->depth + at,
                              .through = job->through + (ptrdiff_t)across * beam->tubes[0] + along,
                              .by_mean = rows->blend + scratch_row(job),
                              .mean = job->mean + in_slab,
                              .by_depth = job->by_depth + in_slab};
}

static void pass_row(void* user, int64_t row, int32_t worker) {
    const adjoint_job* job = user;
    const ty_adjoint_rows rows = rows_of(job, job->planes->extinction, row, worker);
    const ty_adjoint_tubes tubes = tubes_of(job, row, &rows);
    job->kernels->pass(&rows, &tubes);
}

static void note_row(void* user, int64_t row, int32_t worker) {
    const adjoint_job* job = user;
    const ty_adjoint_rows rows = rows_of(job, job->planes->extinction, row, worker);
    const ty_adjoint_tubes tubes = tubes_of(job, row, &rows);
    job->kernels->note(&rows, &tubes);
}

static void return_row(void* user, int64_t row, int32_t worker) {
    const adjoint_job* job = user;
    ty_adjoint_rows rows = rows_of(job, job->planes->weight[0], row, worker);
    const ty_adjoint_tubes tubes = tubes_of(job, row, &rows);
    double* sums = job->at->sums[row];
    if (job->loss->channels == 1) {
        sums[0] += job->kernels->back_of_one(&rows, &tubes, ty_uncollided_loss_color(job->loss, job->at->source, 0));
        return;
    }
    job->kernels->begin(&rows, &tubes);
    for (int32_t c = 0; c < job->loss->channels; ++c) {
        rows = rows_of(job, job->planes->weight[c], row, worker);
        sums[c] += job->kernels->weigh(&rows, &tubes, ty_uncollided_loss_color(job->loss, job->at->source, c));
    }
    job->kernels->back(&rows, &tubes);
}

/* Adds the derivatives by depth of the nine tubes that overlap each cell of a row, and the means of these. */
static void gather_row(void* user, int64_t v, int32_t worker) {
    const adjoint_job* job = user;
    ty_adjoint_rows rows = rows_of(job, job->planes->extinction, v, worker);
    for (int64_t b = 0; b < 3; ++b) rows.cells[b] = job->by_depth + (v + BORDER - b) * job->width;
    job->kernels->gather(&rows, job->beam->length, (float*)cell_row(job, job->planes->gradient, v));
    if (job->planes->transmittance == NULL) return;
    for (int64_t b = 0; b < 3; ++b) rows.cells[b] = job->mean + (v + BORDER - b) * job->width;
    job->kernels->gather(&rows, 1, (float*)cell_row(job, job->planes->transmittance, v));
}

/* ---- blocks of slabs ---- */

static int32_t blocks_of(const ty_collimated* beam) {
    return (beam->size[2] + BLOCK - 1) / BLOCK;
}

static int32_t end_of(const ty_collimated* beam, int32_t block) {
    return (block + 1) * BLOCK < beam->size[2] ? (block + 1) * BLOCK : beam->size[2];
}

/* Copies the tubes that overlap the slab at hand, to or from where a block keeps them. */
static void keep_tubes(const adjoint_job* job, float* begun, bool back) {
    const ty_adjoint_rows none = {.blend = job->scratch};
    const size_t size = sizeof *begun * (size_t)job->width;
    for (int32_t row = 0; row < job->rows; ++row, begun += job->width) {
        float* tubes = tubes_of(job, row, &none).through;
        if (back)
            memcpy(tubes, begun, size);
        else
            memcpy(begun, tubes, size);
    }
}

static void run_rows(const adjoint_job* job, int32_t rows, ty_parallel_fn body) {
    const bool alone = tubes_of_slab(job) < TUBES_FOR_THREADS;
    ty_parallel_flushed(alone ? NULL : job->beam->context, rows, body, (void*)job);
}

static float* begun_of(const adjoint_job* job, int32_t block) {
    return job->at->begun + tubes_of_slab(job) * (size_t)block;
}

static void pass_block(adjoint_job* job, int32_t block) {
    const int32_t end = end_of(job->beam, block);
    job->through = job->at->through;
    job->slab = block * BLOCK;
    keep_tubes(job, begun_of(job, block), false);
    /* Nothing follows the last block. */
    for (; job->slab < end && end < job->beam->size[2]; ++job->slab) run_rows(job, job->rows, pass_row);
}

/* Tubes that enter the box within the block have all of their light. */
static void return_block(adjoint_job* job, int32_t block) {
    const size_t tubes = ty_collimated_tubes(job->beam);
    const int32_t begin = block * BLOCK, end = end_of(job->beam, block);
    job->through = job->light;
    job->slab = begin;
    for (size_t t = 0; t < tubes; ++t) job->light[t] = 1;
    keep_tubes(job, begun_of(job, block), true);
    for (; job->slab < end; ++job->slab) run_rows(job, job->rows, note_row);
    job->through = job->at->through;
    for (job->slab = end - 1; job->slab >= begin; --job->slab) {
        run_rows(job, job->rows, return_row);
        run_rows(job, job->beam->size[1], gather_row);
    }
}

static void choose_passage(adjoint_job* job, const passage* at) {
    job->at = at;
    job->beam = &at->beam;
}

static void pass_all(adjoint_job* job, const passage* all, int32_t count) {
    const int32_t blocks = blocks_of(&all[0].beam);
    for (int32_t i = 0; i < count; ++i) {
        const size_t tubes = ty_collimated_tubes(&all[i].beam);
        for (size_t t = 0; t < tubes; ++t) all[i].through[t] = 1;
    }
    for (int32_t b = 0; b < blocks; ++b)
        for (int32_t i = 0; i < count; ++i) {
            choose_passage(job, &all[i]);
            pass_block(job, b);
        }
    for (int32_t i = 0; i < count; ++i) memset(all[i].through, 0, sizeof(float) * ty_collimated_tubes(&all[i].beam));
    for (int32_t b = blocks - 1; b >= 0; --b)
        for (int32_t i = 0; i < count; ++i) {
            choose_passage(job, &all[i]);
            return_block(job, b);
        }
}

/* Room for so many floats. */
static ty_result reserve(ty_context* context, ty_collimated_scratch* scratch, size_t count) {
    if (scratch->count >= count) return TY_OK;
    ty_collimated_scratch_free(context, scratch);
    scratch->floats = ty_alloc_array(context, count, sizeof *scratch->floats, false);
    if (scratch->floats == NULL) return TY_ERROR_MEMORY;
    scratch->count = count;
    return TY_OK;
}

void ty_collimated_scratch_free(ty_context* context, ty_collimated_scratch* scratch) {
    ty_free_array(context, scratch->floats, scratch->count, sizeof *scratch->floats);
    *scratch = (ty_collimated_scratch){.floats = NULL};
}

/* Memory for passages with one sweep axis. */
static ty_result place(adjoint_job* job, passage* all, int32_t count) {
    const ty_collimated* beam = &all[0].beam;
    ty_context* context = job->medium->context;
    job->width = beam->size[0] + BORDER;
    job->rows = beam->size[1] + BORDER;
    job->beam = beam;
    size_t tubes = 0, max_tubes = 0;
    const size_t slab = tubes_of_slab(job), begun = slab * (size_t)blocks_of(beam);
    for (int32_t i = 0; i < count; ++i) {
        const size_t own = ty_collimated_tubes(&all[i].beam);
        tubes += own;
        max_tubes = own > max_tubes ? own : max_tubes;
    }
    const size_t work = SCRATCH_ROWS * scratch_row(job) * (size_t)ty_context_threads(context);
    const size_t whole = tubes + begun * (size_t)count + max_tubes + (2 * BLOCK + 2) * slab + work;
    const ty_result result = reserve(context, job->memory, whole);
    if (result != TY_OK) return result;
    job->light = job->memory->floats;
    job->before = job->light + max_tubes;
    job->depth = job->before + BLOCK * slab;
    job->by_depth = job->depth + BLOCK * slab;
    job->mean = job->by_depth + slab;
    job->scratch = job->mean + slab;
    float* next = job->scratch + work;
    for (int32_t i = 0; i < count; ++i) {
        all[i].through = next;
        all[i].begun = next + ty_collimated_tubes(&all[i].beam);
        next = all[i].begun + begun;
        all[i].sums = ty_alloc_array(context, (size_t)job->rows, sizeof *all[i].sums, true);
        if (all[i].sums == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static ty_result pass_placed(adjoint_job* job, passage* all, int32_t count, double (*strength)[3]) {
    const ty_result result = place(job, all, count);
    if (result == TY_OK) pass_all(job, all, count);
    for (int32_t i = 0; i < count; ++i) {
        for (int32_t r = 0; r < job->rows && result == TY_OK; ++r)
            for (int32_t c = 0; c < job->loss->channels; ++c)
                ty_uncollided_loss_add(job->loss, all[i].source, c, all[i].sums[r][c], strength[all[i].source->light]);
        ty_free_array(job->medium->context, all[i].sums, (size_t)job->rows, sizeof *all[i].sums);
    }
    return result;
}

static ty_result pass_together(adjoint_job* job, const ty_discrete_light* const* sources, int32_t count,
                               double (*strength)[3]) {
    static const ty_scene_view without_surfaces;
    const double outside[2][3] = {{0}};
    passage all[TOGETHER] = {{.source = NULL}};
    ty_result result = TY_OK;
    int32_t begun = 0;
    for (; begun < count && result == TY_OK; ++begun) {
        all[begun].source = sources[begun];
        result =
            ty_collimated_begin(&without_surfaces, job->medium, outside, sources[begun]->direction, &all[begun].beam);
    }
    if (result == TY_OK) result = pass_placed(job, all, count, strength);
    for (int32_t i = 0; i < begun; ++i) ty_collimated_end(&all[i].beam);
    return result;
}

/* ---- cells with x and z exchanged ---- */

/* Copies of all planes; those of results are zeros. */
static ty_result exchange_all(const adjoint_job* job, const cell_planes* planes, cell_planes* out) {
    const ty_grid_medium* medium = job->medium;
    float* copies[4] = {NULL};
    for (int32_t c = -1; c < job->loss->channels; ++c) {
        float* copy = copies[c + 1] = ty_alloc_array(medium->context, medium->cells, sizeof *copy, false);
        if (copy == NULL) break;
        ty_exchange_axes(medium->context, medium->box.size, c < 0 ? planes->extinction : planes->weight[c], copy,
                         false);
    }
    out->extinction = copies[0];
    for (int32_t c = 0; c < 3; ++c) out->weight[c] = copies[c + 1];
    out->gradient = ty_alloc_array(medium->context, medium->cells, sizeof *out->gradient, true);
    out->transmittance = planes->transmittance != NULL
                             ? ty_alloc_array(medium->context, medium->cells, sizeof *out->transmittance, true)
                             : NULL;
    const bool whole = copies[job->loss->channels] != NULL && out->gradient != NULL;
    return whole && (out->transmittance != NULL) == (planes->transmittance != NULL) ? TY_OK : TY_ERROR_MEMORY;
}

static void free_exchanged(const ty_grid_medium* medium, const cell_planes* planes) {
    ty_free_array(medium->context, (float*)planes->extinction, medium->cells, sizeof(float));
    for (int32_t c = 0; c < 3; ++c)
        ty_free_array(medium->context, (float*)planes->weight[c], medium->cells, sizeof(float));
    ty_free_array(medium->context, planes->gradient, medium->cells, sizeof(float));
    ty_free_array(medium->context, planes->transmittance, medium->cells, sizeof(float));
}

/* ---- all directions ---- */

static bool is_parallel(const ty_discrete_light* source) {
    return source->kind == TY_DISCRETE_DIRECTIONAL;
}

/* Those that cross the most cells along x, or all others. */
static ty_result pass_directions(adjoint_job* job, bool along_x, double (*strength)[3]) {
    const ty_uncollided_loss* loss = job->loss;
    ty_result result = TY_OK;
    for (int32_t sweep = along_x ? 0 : 2; sweep < (along_x ? 2 : 6); ++sweep) {
        const ty_discrete_light* together[TOGETHER];
        int32_t found = 0;
        for (int32_t i = 0; i < loss->count && result == TY_OK; ++i) {
            if (!is_parallel(&loss->sources[i]) ||
                ty_collimated_sweep_axis(job->medium, loss->sources[i].direction) != sweep)
                continue;
            together[found++] = &loss->sources[i];
            if (found < TOGETHER) continue;
            result = ty_part_show(loss->progress, "adjoint", (double)i / loss->count);
            if (result == TY_OK) result = pass_together(job, together, found, strength);
            found = 0;
        }
        if (found > 0 && result == TY_OK) result = pass_together(job, together, found, strength);
    }
    return result;
}

static bool has_along_x(const adjoint_job* job) {
    for (int32_t i = 0; i < job->loss->count; ++i)
        if (is_parallel(&job->loss->sources[i]) &&
            ty_collimated_sweep_axis(job->medium, job->loss->sources[i].direction) / 2 == 0)
            return true;
    return false;
}

static ty_result pass_both(adjoint_job* job, const cell_planes* own, double (*strength)[3]) {
    const ty_grid_medium* medium = job->medium;
    ty_result result = pass_directions(job, false, strength);
    if (result != TY_OK || !has_along_x(job)) return result;
    cell_planes exchanged;
    result = exchange_all(job, own, &exchanged);
    job->planes = &exchanged;
    if (result == TY_OK) result = pass_directions(job, true, strength);
    if (result == TY_OK) {
        const int32_t* size = medium->box.size;
        const int32_t exchanged_size[3] = {size[2], size[1], size[0]};
        ty_exchange_axes(medium->context, exchanged_size, exchanged.gradient, own->gradient, true);
        if (own->transmittance != NULL)
            ty_exchange_axes(medium->context, exchanged_size, exchanged.transmittance, own->transmittance, true);
    }
    free_exchanged(medium, &exchanged);
    return result;
}

ty_result ty_collimated_adjoint(const ty_grid_medium* medium, const ty_uncollided_loss* loss, float* gradient,
                                double (*strength)[3]) {
    const cell_planes own = {.extinction = loss->extinction,
                             .weight = {loss->weight[0], loss->weight[1], loss->weight[2]},
                             .gradient = gradient,
                             .transmittance = loss->transmittance};
    ty_collimated_scratch temporary = {.floats = NULL};
    adjoint_job job = {.medium = medium,
                       .loss = loss,
                       .kernels = TY_BEST_KERNELS(ty_collimated_adjoint_kernels),
                       .memory = loss->scratch != NULL ? loss->scratch : &temporary,
                       .planes = &own};
    if (loss->transmittance != NULL) memset(loss->transmittance, 0, sizeof(float) * medium->cells);
    const ty_result result = pass_both(&job, &own, strength);
    ty_collimated_scratch_free(medium->context, &temporary);
    return result;
}
