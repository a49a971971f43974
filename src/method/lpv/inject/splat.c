/* Splats are sorted by slab of cells, row by row; then each slab sums its own splats over all rows in order. */
#include "method/lpv/inject/splat.h"

#include "base/context.h"
#include "base/parallel.h"

/* Approximate number of splats per batch, which fits a cache. */
enum { BATCH = 1 << 17 };

typedef struct splat_job {
    ty_lattice* lattice;
    const ty_splat_rows* rows;
    int32_t slabs, slab_cells;
    int64_t first, count; /* rows of this batch */
    ty_splat* sorted;     /* `max_splats` a row */
    int32_t* begin;       /* slabs + 1 a row: where each slab's splats begin */
    ty_splat* scratch;    /* `max_splats` a worker */
    double* power;        /* 3 a slab */
} splat_job;

/* Sorts the splats of a row by slab, stably. */
static void sort_row(void* user, int64_t index, int32_t worker) {
    const splat_job* job = user;
    const size_t max_splats = (size_t)job->rows->max_splats;
    ty_splat *unsorted = job->scratch + max_splats * (size_t)worker, *sorted = job->sorted + max_splats * (size_t)index;
    int32_t* begin = job->begin + (size_t)index * (size_t)(job->slabs + 1);
    const int32_t count = job->rows->row(job->rows->user, job->first + index, unsorted);
    memset(begin, 0, (size_t)(job->slabs + 1) * sizeof *begin);
    for (int32_t i = 0; i < count; ++i) {
        unsorted[i].slab = unsorted[i].cell / job->slab_cells;
        ++begin[unsorted[i].slab];
    }
    for (int32_t slab = 0, next = 0; slab <= job->slabs; ++slab) {
        const int32_t here = begin[slab];
        begin[slab] = next;
        next += here;
    }
    for (int32_t i = 0; i < count; ++i) sorted[begin[unsorted[i].slab]++] = unsorted[i];
    for (int32_t slab = job->slabs; slab > 0; --slab) begin[slab] = begin[slab - 1];
    begin[0] = 0;
}

/* The factor on a band of a channel in a cell. */
static float band_in(const splat_job* job, int32_t cell, int c, int32_t l) {
    const ty_grid_medium* medium = job->lattice->medium;
    float factor = job->rows->band[l];
    if (l == 0 || !job->rows->anisotropic || medium == NULL) return factor;
    const float g = medium->g[medium->planes == 1 ? 0 : c][cell];
    for (int32_t i = 0; i < l; ++i) factor *= job->lattice->reduces ? ty_reduced_g(g) : g;
    return factor;
}

static void add_splat(const splat_job* job, const ty_splat* splat) {
    ty_lattice* lattice = job->lattice;
    float y[TY_SH_TERMS];
    ty_sh_at(splat->axis, lattice->bands, y);
    for (int c = 0; c < 3; ++c)
        for (int32_t l = 0; l < lattice->bands; ++l) {
            const float factor = splat->power[c] * band_in(job, splat->cell, c, l);
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
                lattice->propagated_sh[c][t][splat->cell] += factor * y[t];
        }
}

static void add_slab(void* user, int64_t slab, int32_t worker) {
    (void)worker;
    const splat_job* job = user;
    double* power = job->power + 3 * slab;
    for (int64_t row = 0; row < job->count; ++row) {
        const ty_splat* splats = job->sorted + (size_t)job->rows->max_splats * (size_t)row;
        const int32_t* begin = job->begin + (size_t)row * (size_t)(job->slabs + 1) + slab;
        for (int32_t i = begin[0]; i < begin[1]; ++i) {
            add_splat(job, &splats[i]);
            for (int c = 0; c < 3; ++c) power[c] += (double)splats[i].power[c];
        }
    }
}

static void add_batches(splat_job* job, int64_t batch, double power[3]) {
    for (job->first = 0; job->first < job->rows->rows; job->first += batch) {
        job->count = job->rows->rows - job->first < batch ? job->rows->rows - job->first : batch;
        ty_parallel_flushed(job->lattice->context, job->count, sort_row, job);
        ty_parallel_flushed(job->lattice->context, job->slabs, add_slab, job);
    }
    for (int32_t slab = 0; slab < job->slabs; ++slab)
        for (int c = 0; c < 3; ++c) power[c] += job->power[3 * slab + c];
}

ty_result ty_splats_add(ty_lattice* lattice, const ty_splat_rows* rows, double power[3]) {
    ty_context* context = lattice->context;
    const size_t max_splats = (size_t)rows->max_splats, workers = (size_t)ty_context_threads(context);
    const int64_t fitting = BATCH / rows->max_splats > 0 ? BATCH / rows->max_splats : 1;
    const size_t batch = (size_t)(fitting < rows->rows ? fitting : rows->rows);
    splat_job job = {.lattice = lattice, .rows = rows, .slabs = lattice->box.size[2]};
    job.slab_cells = lattice->box.size[0] * lattice->box.size[1];
    const size_t begins = batch * (size_t)(job.slabs + 1), powers = 3 * (size_t)job.slabs;
    job.sorted = ty_alloc_array(context, batch * max_splats, sizeof *job.sorted, false);
    job.begin = ty_alloc_array(context, begins, sizeof *job.begin, false);
    job.scratch = ty_alloc_array(context, workers * max_splats, sizeof *job.scratch, false);
    job.power = ty_alloc_array(context, powers, sizeof *job.power, true);
    const bool taken = job.sorted != NULL && job.begin != NULL && job.scratch != NULL && job.power != NULL;
    if (taken) add_batches(&job, (int64_t)batch, power);
    ty_free_array(context, job.sorted, batch * max_splats, sizeof *job.sorted);
    ty_free_array(context, job.begin, begins, sizeof *job.begin);
    ty_free_array(context, job.scratch, workers * max_splats, sizeof *job.scratch);
    ty_free_array(context, job.power, powers, sizeof *job.power);
    return taken ? TY_OK : TY_ERROR_MEMORY;
}
