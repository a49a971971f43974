/* Grids, dense or in blocks, of sparse trees. */
#include "io/volumes/sparse.h"

#include "base/context.h"
#include "base/half.h"
#include "grid/grid.h"
#include "io/volumes/volume_file.h"

#include <stdatomic.h>
#include <stdlib.h>

enum { CELLS_A_TASK = 64 };

ty_sparse ty_sparse_begin(ty_context* context, const char* path, const char* name) {
    return (ty_sparse){.context = context,
                       .path = path,
                       .name = name,
                       .lower = {INT32_MAX, INT32_MAX, INT32_MAX},
                       .upper = {INT32_MIN, INT32_MIN, INT32_MIN}};
}

void ty_sparse_end(ty_sparse* sparse) {
    ty_free_array(sparse->context, sparse->cells, sparse->capacity, sizeof *sparse->cells);
    ty_free_array(sparse->context, sparse->roots, sparse->root_capacity, sizeof *sparse->roots);
    *sparse = (ty_sparse){0};
}

static void include(ty_sparse* sparse, int axis, int32_t lower, int32_t upper) {
    if (lower < sparse->lower[axis]) sparse->lower[axis] = lower;
    if (upper > sparse->upper[axis]) sparse->upper[axis] = upper;
}

void ty_sparse_restart(ty_sparse* sparse) {
    for (int a = 0; a < 3; ++a) {
        const int64_t lower = sparse->active == 0 ? 0 : sparse->lower[a];
        const int64_t side = sparse->active == 0 ? 1 : sparse->upper[a] - lower + 1;
        const int32_t shift = (int32_t)(lower & (TY_GRID_BLOCK - 1));
        const int32_t size = side < INT32_MAX - TY_GRID_BLOCK ? (int32_t)side : INT32_MAX - TY_GRID_BLOCK;
        int32_t first, end;
        ty_grid_plan_blocks(&sparse->plan, a, size, shift, &first, &end);
        sparse->keep[0][a] = lower - shift + (int64_t)first * TY_GRID_BLOCK;
        sparse->keep[1][a] = lower - shift + (int64_t)end * TY_GRID_BLOCK;
        sparse->lower[a] = INT32_MAX;
        sparse->upper[a] = INT32_MIN;
    }
    sparse->active = 0;
    sparse->leaves = 0;
    sparse->root_count = 0;
    sparse->measures = false;
}

static bool is_kept(const ty_sparse* sparse, const ty_sparse_cell* cell) {
    bool kept = !sparse->measures;
    for (int a = 0; a < 3 && sparse->plan.part; ++a)
        kept =
            kept && cell->origin[a] < sparse->keep[1][a] && (int64_t)cell->origin[a] + cell->side > sparse->keep[0][a];
    return kept;
}

static bool add_cell(ty_sparse* sparse, const ty_sparse_cell* cell) {
    if (!is_kept(sparse, cell)) return true;
    if (!ty_grow_array(sparse->context, (void**)&sparse->cells, &sparse->capacity, sparse->count, sizeof *cell))
        return false;
    sparse->cells[sparse->count++] = *cell;
    return true;
}

bool ty_sparse_add_root(ty_sparse* sparse, const int32_t origin[3]) {
    if (!ty_grow_array(sparse->context, (void**)&sparse->roots, &sparse->root_capacity, sparse->root_count,
                       sizeof *sparse->roots))
        return false;
    memcpy(sparse->roots[sparse->root_count++], origin, sizeof *sparse->roots);
    return true;
}

static int compare_origins(const void* a, const void* b) {
    return memcmp(a, b, sizeof(int32_t[3]));
}

/* True if all root entries have different origins. */
static bool roots_are_unique(const ty_sparse* sparse) {
    if (sparse->root_count == 0) return true;
    qsort(sparse->roots, sparse->root_count, sizeof *sparse->roots, compare_origins);
    for (size_t i = 1; i < sparse->root_count; ++i)
        if (compare_origins(sparse->roots[i - 1], sparse->roots[i]) == 0) return false;
    return true;
}

bool ty_sparse_add_tile(ty_sparse* sparse, const int32_t origin[3], int32_t side, bool active, float value) {
    if (active) {
        sparse->active += (int64_t)side * side * side;
        for (int a = 0; a < 3; ++a) include(sparse, a, origin[a], origin[a] + (side - 1));
    }
    if (ty_bits_from_float(value) == ty_bits_from_float(sparse->background)) return true;
    const ty_sparse_cell cell = {{origin[0], origin[1], origin[2]}, side, value, TY_SPARSE_TILE};
    return add_cell(sparse, &cell);
}

/* Extends the active range along an axis by the lowest and highest set bit of 8. */
static void include_bits(ty_sparse* sparse, int axis, int32_t origin, unsigned bits) {
    include(sparse, axis, origin + __builtin_ctz(bits), origin + (31 - __builtin_clz(bits)));
}

bool ty_sparse_add_leaf(ty_sparse* sparse, const int32_t origin[3], const uint8_t* mask, uint64_t leaf) {
    unsigned on[3] = {0, 0, 0};
    for (int byte = 0; byte < TY_LEAF_VOXELS / 8; ++byte) {
        if (mask[byte] == 0) continue;
        on[0] |= 1u << byte / 8;
        on[1] |= 1u << byte % 8;
        on[2] |= mask[byte];
        sparse->active += __builtin_popcount(mask[byte]);
    }
    for (int a = 0; a < 3 && on[0] != 0; ++a) include_bits(sparse, a, origin[a], on[a]);
    const ty_sparse_cell cell = {{origin[0], origin[1], origin[2]}, TY_LEAF_SIDE, 0, leaf};
    ++sparse->leaves;
    return add_cell(sparse, &cell);
}

/* Job of ty_parallel_for: the slices of a dense grid get the background, then groups of cells their values. */
typedef struct fill_job {
    const ty_sparse* sparse;
    ty_sparse_decode decode;
    const void* user;
    const int32_t *lower, *size; /* of the active box */
    void* values;
    ty_grid_blocks blocks;
    _Atomic bool fail_corrupt;
} fill_job;

static void fill_values(const fill_job* job, size_t at, size_t count, float value) {
    if (job->sparse->type == TY_GRID_F16) {
        const uint16_t half = ty_float_to_half(value);
        uint16_t* to = (uint16_t*)job->values + at;
        for (size_t i = 0; i < count; ++i) to[i] = half;
    } else {
        float* to = (float*)job->values + at;
        for (size_t i = 0; i < count; ++i) to[i] = value;
    }
}

static void fill_slice(void* user, int64_t k, int32_t worker) {
    (void)worker;
    const fill_job* job = user;
    const size_t voxels = (size_t)job->size[0] * (size_t)job->size[1];
    fill_values(job, voxels * (size_t)k, voxels, job->sparse->background);
}

/* Intersection of a cell with the active box, in voxels of the box: [first, last). */
static bool clip_cell(const fill_job* job, const ty_sparse_cell* cell, int64_t first[3], int64_t last[3]) {
    for (int a = 0; a < 3; ++a) {
        const int64_t start = (int64_t)cell->origin[a] - job->lower[a], end = start + cell->side;
        first[a] = start < 0 ? 0 : start;
        last[a] = end > job->size[a] ? job->size[a] : end;
        if (first[a] >= last[a]) return false;
    }
    return true;
}

/* The entry of a table for a voxel of the active box. */
static size_t table_index(const ty_grid_blocks* blocks, int64_t i, int64_t j, int64_t k) {
    const int64_t x = (i + blocks->shift[0]) / TY_GRID_BLOCK, y = (j + blocks->shift[1]) / TY_GRID_BLOCK;
    const int64_t z = (k + blocks->shift[2]) / TY_GRID_BLOCK;
    return (size_t)(x + blocks->size[0] * (y + blocks->size[1] * z));
}

#define TY_COPY_ROW(type, from, to, count)                                                                             \
    for (size_t i = 0; i < (count); ++i) ((type*)(to))[i] = ((const type*)(from))[64 * i]

/* Where the value of a voxel of a leaf is stored. */
static size_t stored_at(const fill_job* job, const int64_t origin[3], int64_t i, int64_t j, int64_t k) {
    if (job->blocks.table == NULL) return (size_t)(i + job->size[0] * (j + job->size[1] * k));
    const size_t block = job->blocks.table[table_index(&job->blocks, i, j, k)];
    return block * TY_GRID_BLOCK_VOXELS +
           (size_t)(i - origin[0] + TY_GRID_BLOCK * (j - origin[1] + TY_GRID_BLOCK * (k - origin[2])));
}

static void copy_leaf(const fill_job* job, const ty_sparse_cell* cell, const void* leaf, const int64_t first[3],
                      const int64_t last[3]) {
    const size_t count = (size_t)(last[0] - first[0]);
    const int64_t origin[3] = {(int64_t)cell->origin[0] - job->lower[0], (int64_t)cell->origin[1] - job->lower[1],
                               (int64_t)cell->origin[2] - job->lower[2]};
    for (int64_t k = first[2]; k < last[2]; ++k)
        for (int64_t j = first[1]; j < last[1]; ++j) {
            const size_t to = stored_at(job, origin, first[0], j, k);
            const size_t from = (size_t)(64 * (first[0] - origin[0]) + 8 * (j - origin[1]) + (k - origin[2]));
            if (job->sparse->type == TY_GRID_F16)
                TY_COPY_ROW(uint16_t, (const uint16_t*)leaf + from, (uint16_t*)job->values + to, count);
            else
                TY_COPY_ROW(float, (const float*)leaf + from, (float*)job->values + to, count);
        }
}

static void fill_cell(fill_job* job, const ty_sparse_cell* cell) {
    int64_t first[3], last[3];
    if (!clip_cell(job, cell, first, last)) return;
    if (cell->leaf == TY_SPARSE_TILE) {
        for (int64_t k = first[2]; k < last[2] && job->blocks.table == NULL; ++k)
            for (int64_t j = first[1]; j < last[1]; ++j)
                fill_values(job, (size_t)(first[0] + job->size[0] * (j + job->size[1] * k)),
                            (size_t)(last[0] - first[0]), cell->value);
        return;
    }
    float leaf[TY_LEAF_VOXELS]; /* or as many halves */
    if (job->decode(job->user, cell->leaf, leaf))
        copy_leaf(job, cell, leaf, first, last);
    else
        atomic_store(&job->fail_corrupt, true);
}

static void fill_cells(void* user, int64_t task, int32_t worker) {
    (void)worker;
    fill_job* job = user;
    const size_t begin = (size_t)task * CELLS_A_TASK;
    for (size_t i = begin; i < job->sparse->count && i < begin + CELLS_A_TASK; ++i)
        fill_cell(job, &job->sparse->cells[i]);
}

static ty_result fail_corrupt(const ty_sparse* sparse) {
    return ty_fail(sparse->context, TY_ERROR_INPUT, "%s: damaged or cut short (%s)", sparse->path, sparse->name);
}

/* Sets the grid's def without its values: the active box and its transform. */
static ty_result describe_grid(const ty_sparse* sparse, const ty_affine* index_to_world, ty_grid_def* def,
                               int32_t lower[3], size_t* voxels) {
    const bool empty = sparse->active == 0;
    int64_t sides[3];
    ty_affine offset = ty_affine_identity();
    for (int a = 0; a < 3; ++a) {
        lower[a] = empty ? 0 : sparse->lower[a];
        sides[a] = empty ? 1 : (int64_t)sparse->upper[a] - lower[a] + 1;
        offset.m[4 * a + 3] = lower[a];
    }
    if (!isfinite(sparse->background))
        return ty_fail(sparse->context, TY_ERROR_INPUT, "%s: the background of grid \"%s\" is not finite", sparse->path,
                       sparse->name);
    const ty_result result =
        ty_check_volume_storage(sparse->context, sparse->path, ty_plan_limits(&sparse->plan), true, sides, voxels);
    if (result != TY_OK) return result;
    *def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) def->size[a] = (int32_t)sides[a];
    def->type = sparse->type;
    def->background = sparse->background;
    def->placed = true;
    def->index_to_local = ty_affine_multiply(index_to_world, &offset);
    return TY_OK;
}

/* ---- blocks ---- */

static bool is_tile(const ty_sparse_cell* cell) {
    return cell->leaf == TY_SPARSE_TILE;
}

/* Number of blocks with the background's. Neighbouring tiles of one value share a block. */
static size_t count_blocks(const fill_job* job) {
    size_t count = 1;
    const ty_sparse_cell* tile = NULL;
    int64_t first[3], last[3];
    for (size_t i = 0; i < job->sparse->count; ++i) {
        const ty_sparse_cell* cell = &job->sparse->cells[i];
        if (!clip_cell(job, cell, first, last)) continue;
        const bool shared = is_tile(cell) && tile != NULL && tile->value == cell->value;
        count += !shared;
        if (is_tile(cell)) tile = cell;
    }
    return count;
}

static void fill_block(const fill_job* job, uint32_t number, float value) {
    fill_values(job, (size_t)number * TY_GRID_BLOCK_VOXELS, TY_GRID_BLOCK_VOXELS, value);
}

/* Enters a cell's block into the table; the sides and origins of cells are multiples of those of blocks. */
static void enter_cell(fill_job* job, const int64_t first[3], const int64_t last[3], uint32_t number) {
    for (int64_t k = first[2] + job->blocks.shift[2]; k < last[2] + job->blocks.shift[2];
         k += TY_GRID_BLOCK - k % TY_GRID_BLOCK)
        for (int64_t j = first[1] + job->blocks.shift[1]; j < last[1] + job->blocks.shift[1];
             j += TY_GRID_BLOCK - j % TY_GRID_BLOCK) {
            uint32_t* row =
                job->blocks.table +
                (size_t)job->blocks.size[0] * (size_t)(j / TY_GRID_BLOCK + job->blocks.size[1] * (k / TY_GRID_BLOCK));
            const int64_t end = (last[0] - 1 + job->blocks.shift[0]) / TY_GRID_BLOCK;
            for (int64_t i = (first[0] + job->blocks.shift[0]) / TY_GRID_BLOCK; i <= end; ++i) row[i] = number;
        }
}

/* Fills the table, and the blocks of tiles; those of leaves get the background, which stays beyond the active box. */
static void enter_cells(fill_job* job) {
    const ty_sparse_cell* tile = NULL;
    uint32_t tile_block = 0;
    int64_t first[3], last[3];
    fill_block(job, 0, job->sparse->background);
    for (size_t i = 0; i < job->sparse->count; ++i) {
        const ty_sparse_cell* cell = &job->sparse->cells[i];
        if (!clip_cell(job, cell, first, last)) continue;
        uint32_t number = tile_block;
        if (!is_tile(cell) || tile == NULL || tile->value != cell->value) {
            number = job->blocks.count++;
            fill_block(job, number, is_tile(cell) ? cell->value : job->sparse->background);
        }
        if (is_tile(cell)) {
            tile = cell;
            tile_block = number;
        }
        enter_cell(job, first, last, number);
    }
}

static void fill_all_cells(fill_job* job) {
    const size_t tasks = (job->sparse->count + CELLS_A_TASK - 1) / CELLS_A_TASK;
    ty_parallel_for(job->sparse->context, (int64_t)tasks, fill_cells, job);
}

static ty_result make_blocks(fill_job* job, const ty_grid_def* def, const int32_t shift[3], size_t blocks,
                             ty_grid** out) {
    ty_context* context = job->sparse->context;
    if (ty_grid_blocks_table(context, def->size, shift, &job->blocks) == NULL) return TY_ERROR_MEMORY;
    ty_result result;
    job->blocks.count = (uint32_t)blocks;
    job->values =
        ty_grid_blocks_values(context, def->type, job->sparse->plan.storage == TY_GRID_PAGED, &job->blocks, &result);
    job->blocks.count = 1;
    if (result == TY_OK) {
        enter_cells(job);
        fill_all_cells(job);
        if (!atomic_load(&job->fail_corrupt)) return ty_grid_adopt_blocks(context, def, &job->blocks, job->values, out);
    }
    job->blocks.count = (uint32_t)blocks;
    ty_grid_free_blocks(context, def->type, &job->blocks, job->values);
    return result == TY_OK ? fail_corrupt(job->sparse) : result;
}

static ty_result make_dense(fill_job* job, const ty_grid_def* def, size_t voxels, ty_grid** out) {
    ty_context* context = job->sparse->context;
    const size_t value_size = ty_grid_value_size(def->type);
    job->values = ty_alloc_array(context, voxels, value_size, false);
    if (job->values == NULL) return TY_ERROR_MEMORY;
    ty_parallel_for(context, def->size[2], fill_slice, job);
    fill_all_cells(job);
    if (!atomic_load(&job->fail_corrupt)) return ty_grid_adopt(context, def, job->values, out);
    ty_free_array(context, job->values, voxels, value_size);
    return fail_corrupt(job->sparse);
}

ty_result ty_sparse_make_grid(const ty_sparse* sparse, ty_sparse_decode decode, const void* user,
                              const ty_affine* index_to_world, ty_grid** out) {
    ty_grid_def def;
    int32_t lower[3], shift[3];
    size_t voxels = 0, table = 1;
    if (!roots_are_unique(sparse)) return fail_corrupt(sparse);
    const ty_result result = describe_grid(sparse, index_to_world, &def, lower, &voxels);
    if (result != TY_OK) return result;
    fill_job job = {.sparse = sparse, .decode = decode, .user = user, .lower = lower, .size = def.size};
    atomic_init(&job.fail_corrupt, false);
    for (int a = 0; a < 3; ++a) {
        shift[a] = lower[a] & (TY_GRID_BLOCK - 1); /* of blocks that are leaves */
        table *= (size_t)(def.size[a] + shift[a] + TY_GRID_BLOCK - 1) / TY_GRID_BLOCK;
    }
    const size_t blocks = count_blocks(&job);
    if (sparse->plan.storage == TY_GRID_PAGED || sparse->plan.part ||
        ty_grid_saves_memory(def.type, voxels, table, blocks))
        return make_blocks(&job, &def, shift, blocks, out);
    return make_dense(&job, &def, voxels, out);
}
