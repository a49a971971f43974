/* Merging of all ordinates' light in one grid, block by block, so that the cells of a light that a block reads stay
 * in the caches. */
#include "method/pop/merge/merge.h"

#include "base/context.h"
#include "base/parallel.h"
#include "method/pop/merge/merge_kernel.h"

/* ---- memory ---- */

ty_result ty_pop_merged_create(ty_context* context, const ty_grid_box* box, bool with_unpropagated,
                               ty_pop_merged* out) {
    const size_t cells = (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
    out->box = *box;
    for (int c = 0; c < 3; ++c) {
        out->accumulated_radiance[c] = ty_alloc_array(context, cells, sizeof(float), true);
        out->fluence[c] = ty_alloc_array(context, cells, sizeof(float), true);
        if (with_unpropagated) out->unpropagated[c] = ty_alloc_array(context, cells, sizeof(float), true);
        if (out->accumulated_radiance[c] == NULL || out->fluence[c] == NULL ||
            (with_unpropagated && out->unpropagated[c] == NULL))
            return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

void ty_pop_merged_destroy(ty_context* context, ty_pop_merged* merged) {
    const int32_t* size = merged->box.size;
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    for (int c = 0; c < 3; ++c) {
        ty_free_array(context, merged->accumulated_radiance[c], cells, sizeof(float));
        ty_free_array(context, merged->fluence[c], cells, sizeof(float));
        ty_free_array(context, merged->unpropagated[c], cells, sizeof(float));
    }
}

/* ---- merging ---- */

enum { SLABS = 4, SLAB_CELLS = TY_POP_MERGE_ROWS * TY_POP_MERGE_RUN };

typedef struct merge_job {
    const ty_pop_merge_kernels* kernels;
    const ty_pop_light* lights;
    int32_t count;
    ty_pop_merged* merged;
    int32_t runs, length; /* runs per row, and cells per run at most */
    int32_t blocks;       /* along y */
} merge_job;

/* A block of merged cells. Sums of its slabs follow each other, rows without gaps. */
typedef struct block {
    int32_t lower[3], size[3];
    _Alignas(64) float sums[SLABS][SLAB_CELLS * TY_POP_MERGE_SUMS];
} block;

static float center(const ty_grid_box* box, int axis, int32_t cell) {
    return (float)(box->lower[axis] + (cell + 0.5) * ty_pop_cell_edge(box, axis));
}

static void add_light(const merge_job* w, const ty_pop_light* light, block* b) {
    const ty_grid_box* box = &w->merged->box;
    for (int32_t z = 0; z < b->size[2]; ++z) {
        const ty_pop_merge_rows rows = {
            .count = b->size[0],
            .rows = b->size[1],
            .first =
                ty_vec_make(center(box, 0, b->lower[0]), center(box, 1, b->lower[1]), center(box, 2, b->lower[2] + z)),
            .step = {(float)ty_pop_cell_edge(box, 0), (float)ty_pop_cell_edge(box, 1)},
            .sums = b->sums[z],
        };
        w->kernels->merge(light, &rows);
    }
}

/* Index of a row's first cell in the merged arrays. */
static size_t row_start(const merge_job* w, const block* b, int32_t row) {
    const int32_t* size = w->merged->box.size;
    const size_t y = (size_t)(b->lower[1] + row % b->size[1]), z = (size_t)(b->lower[2] + row / b->size[1]);
    return (z * (size_t)size[1] + y) * (size_t)size[0] + (size_t)b->lower[0];
}

static float* row_sums(block* b, int32_t row) {
    return b->sums[row / b->size[1]] + TY_POP_MERGE_SUMS * (row % b->size[1]) * b->size[0];
}

/* The sums start from the stored values, so that results do not depend on the batch size. */
static void load_block(const merge_job* w, block* b) {
    const ty_pop_merged* merged = w->merged;
    for (int32_t row = 0; row < b->size[1] * b->size[2]; ++row) {
        const size_t first = row_start(w, b, row);
        float* sums = row_sums(b, row);
        for (int32_t n = 0; n < b->size[0]; ++n)
            for (int c = 0; c < TY_POP_MERGE_SUMS; ++c)
                sums[TY_POP_MERGE_SUMS * n + c] = c < 3   ? merged->accumulated_radiance[c][first + (size_t)n]
                                                  : c < 6 ? merged->fluence[c - 3][first + (size_t)n]
                                                          : 0;
    }
}

static void store_block(const merge_job* w, block* b) {
    const ty_pop_merged* merged = w->merged;
    for (int32_t row = 0; row < b->size[1] * b->size[2]; ++row) {
        const size_t first = row_start(w, b, row);
        const float* sums = row_sums(b, row);
        for (int32_t n = 0; n < b->size[0]; ++n)
            for (int c = 0; c < 3; ++c) {
                merged->accumulated_radiance[c][first + (size_t)n] = sums[TY_POP_MERGE_SUMS * n + c];
                merged->fluence[c][first + (size_t)n] = sums[TY_POP_MERGE_SUMS * n + 3 + c];
            }
    }
}

static int32_t min_int(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static void merge_block(void* user, int64_t index, int32_t worker) {
    const merge_job* w = user;
    const int32_t* size = w->merged->box.size;
    const int32_t run = (int32_t)(index % w->runs), remaining = (int32_t)(index / w->runs);
    const int32_t max_size[3] = {w->length, TY_POP_MERGE_ROWS, SLABS},
                  at[3] = {run, remaining % w->blocks, remaining / w->blocks};
    block b;
    (void)worker;
    for (int a = 0; a < 3; ++a) {
        b.lower[a] = at[a] * max_size[a];
        b.size[a] = min_int(max_size[a], size[a] - b.lower[a]);
    }
    load_block(w, &b);
    for (int32_t l = 0; l < w->count; ++l) add_light(w, &w->lights[l], &b);
    store_block(w, &b);
}

/* Sec. 5.3 (Elek 2014). */
void ty_pop_merge(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged) {
    const int32_t* size = merged->box.size;
    merge_job w = {
        .kernels = TY_BEST_KERNELS(ty_pop_merge_kernels), .lights = lights, .count = count, .merged = merged};
    w.blocks = (size[1] + TY_POP_MERGE_ROWS - 1) / TY_POP_MERGE_ROWS;
    const int32_t runs = (size[0] + TY_POP_MERGE_RUN - 1) / TY_POP_MERGE_RUN;
    w.length = (size[0] + runs - 1) / runs;
    w.runs = (size[0] + w.length - 1) / w.length;
    const int64_t slabs = (size[2] + SLABS - 1) / SLABS;
    ty_parallel_flushed(context, slabs * w.blocks * w.runs, merge_block, &w);
}

/* ---- interpolation on other cells ---- */

bool ty_pop_locate_center(const ty_grid_box* box, const int32_t cell[3], const ty_grid_box* other,
                          ty_cell_point* point) {
    float at[3];
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
        at[a] = (float)((box->lower[a] - other->lower[a] + (cell[a] + 0.5) * ty_pop_cell_edge(box, a)) /
                        ty_pop_cell_edge(other, a));
        inside = inside && at[a] >= 0 && at[a] <= (float)other->size[a];
    }
    *point = ty_cell_locate(other->size, ty_vec_load(at));
    return inside;
}

typedef struct add_job {
    const ty_pop_merged* from;
    ty_pop_merged* to;
} add_job;

static void add_slab(void* user, int64_t z, int32_t worker) {
    const add_job* job = user;
    const int32_t* size = job->to->box.size;
    size_t at = (size_t)z * (size_t)size[1] * (size_t)size[0];
    (void)worker;
    for (int32_t y = 0; y < size[1]; ++y)
        for (int32_t x = 0; x < size[0]; ++x, ++at) {
            const int32_t cell[3] = {x, y, (int32_t)z};
            ty_cell_point point;
            ty_pop_locate_center(&job->to->box, cell, &job->from->box, &point);
            for (int c = 0; c < 3; ++c) {
                job->to->accumulated_radiance[c][at] += ty_cell_value(job->from->accumulated_radiance[c], &point);
                job->to->fluence[c][at] += ty_cell_value(job->from->fluence[c], &point);
            }
        }
}

void ty_pop_merged_add(ty_context* context, const ty_pop_merged* from, ty_pop_merged* to) {
    add_job job = {from, to};
    ty_parallel_flushed(context, to->box.size[2], add_slab, &job);
}
