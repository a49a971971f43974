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
#include "direct/uncollided/collimated.h"
#include "direct/uncollided/collimated_adjoint_kernel.h"

#include <string.h>

/* Tubes beyond either end of a row of cells that overlap it; rows of scratch per worker. */
enum { BORDER = 2, SCRATCH_ROWS = 2 };

/* Smaller slabs are passed by one thread: waking others takes longer. */
enum { TUBES_FOR_THREADS = 1 << 12 };

/* Planes of cells in the order in which rows are along u: the medium's own, or with x and z exchanged. */
typedef struct cell_planes {
    const float *extinction, *weight[3];
    float *gradient, *transmittance; /* transmittance: NULL: not asked for */
} cell_planes;

typedef struct adjoint_job {
    const ty_grid_medium* medium;
    const ty_collimated_loss* loss;
    const ty_collimated_adjoint_kernels* kernels;
    const ty_collimated* beam;
    const ty_discrete_light* source;
    const cell_planes* planes;
    int32_t slab;          /* in the order of travel */
    int32_t width, rows;   /* tubes that overlap a row of cells, and rows of such tubes */
    float *before, *depth; /* of each slab, row and tube: transmittance before the slab, optical depth within it */
    float* through;        /* transmittance of each tube, and then the loss's derivative by it */
    float* by_depth;       /* of the slab's tubes: the loss's derivative by depth */
    float* mean;           /* of the slab's tubes: mean transmittance */
    float* scratch;        /* of each worker */
    ty_collimated_scratch* memory; /* of all of these */
    double (*sums)[3];             /* of each row of tubes: the loss per channel */
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
    const size_t in_slab = (size_t)row * (size_t)job->width, at = tubes_of_slab(job) * (size_t)job->slab + in_slab;
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

/* The color that a channel's weights are of. */
static float color_of(const adjoint_job* job, int32_t channel) {
    const float *color = job->source->color, *multiples = job->loss->multiples;
    if (multiples == NULL) return color[job->loss->first + channel];
    return multiples[0] * color[0] + multiples[1] * color[1] + multiples[2] * color[2];
}

static void return_row(void* user, int64_t row, int32_t worker) {
    const adjoint_job* job = user;
    ty_adjoint_rows rows = rows_of(job, job->planes->extinction, row, worker);
    const ty_adjoint_tubes tubes = tubes_of(job, row, &rows);
    job->kernels->begin(&rows, &tubes);
    for (int32_t c = 0; c < job->loss->channels; ++c) {
        rows = rows_of(job, job->planes->weight[c], row, worker);
        job->sums[row][c] += job->kernels->weigh(&rows, &tubes, color_of(job, c));
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

/* Adds a channel's part of the loss to the light's, divided among the channels that share its weights. */
static void add_strength(const adjoint_job* job, int32_t channel, double part, double strength[3]) {
    const float *multiples = job->loss->multiples, all = color_of(job, channel);
    if (multiples == NULL) strength[job->loss->first + channel] += part;
    for (int c = 0; c < 3 && multiples != NULL && all != 0; ++c)
        strength[c] += part * (double)(multiples[c] * job->source->color[c] / all);
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

static ty_result pass_direction(adjoint_job* job, double strength[3]) {
    ty_context* context = job->beam->context;
    job->width = job->beam->size[0] + BORDER;
    job->rows = job->beam->size[1] + BORDER;
    const size_t tubes = tubes_of_slab(job), all = tubes * (size_t)job->beam->size[2], rows = (size_t)job->rows;
    const size_t through = ty_collimated_tubes(job->beam);
    const size_t work = SCRATCH_ROWS * scratch_row(job) * (size_t)ty_context_threads(context);
    const ty_result result = reserve(context, job->memory, 2 * all + through + 2 * tubes + work);
    if (result != TY_OK) return result;
    job->sums = ty_alloc_array(context, rows, sizeof *job->sums, true);
    if (job->sums == NULL) return TY_ERROR_MEMORY;
    job->before = job->memory->floats;
    job->depth = job->before + all;
    job->through = job->depth + all;
    job->by_depth = job->through + through;
    job->mean = job->by_depth + tubes;
    job->scratch = job->mean + tubes;
    pass_all(job);
    for (size_t r = 0; r < rows; ++r)
        for (int32_t c = 0; c < job->loss->channels; ++c) add_strength(job, c, job->sums[r][c], strength);
    ty_free_array(context, job->sums, rows, sizeof *job->sums);
    return TY_OK;
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

/* Those that cross the most cells along x, or all others. */
static ty_result pass_directions(adjoint_job* job, bool along_x, double (*strength)[3]) {
    static const ty_scene_view without_surfaces;
    const double outside[2][3] = {{0}};
    ty_result result = TY_OK;
    for (int32_t i = 0; i < job->loss->count && result == TY_OK; ++i) {
        ty_collimated beam;
        job->source = &job->loss->sources[i];
        if ((ty_collimated_sweep_axis(job->medium, job->source->direction) / 2 == 0) != along_x) continue;
        result = ty_part_show(job->loss->progress, "adjoint", (double)i / job->loss->count);
        if (result != TY_OK) return result;
        result = ty_collimated_begin(&without_surfaces, job->medium, outside, job->source->direction, &beam);
        job->beam = &beam;
        if (result == TY_OK) result = pass_direction(job, strength[job->source->light]);
        ty_collimated_end(&beam);
    }
    return result;
}

static bool has_along_x(const adjoint_job* job) {
    for (int32_t i = 0; i < job->loss->count; ++i)
        if (ty_collimated_sweep_axis(job->medium, job->loss->sources[i].direction) / 2 == 0) return true;
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

ty_result ty_collimated_adjoint(const ty_grid_medium* medium, const ty_collimated_loss* loss, float* gradient,
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
