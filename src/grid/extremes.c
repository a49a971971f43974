/* Statistics of grids, and the extremes of their bricks. Those of a sparse grid are the same, but for the mean's last
 * digits where blocks of one value other than 0 count as their voxels. */
#include "base/context.h"
#include "grid/grid.h"
#include "grid/lookup.k.h"

/* Extremes and sum of a slice of voxels, how many are active, and its number of non-finite values. */
typedef struct slice_range {
    float min, max;
    double sum;
    int64_t active;
    size_t replaced;
} slice_range;

/* Arguments of the loops: the grid, a result per slice or group of blocks, and buffers of one or more rows of floats
 * per worker. */
typedef struct grid_job {
    ty_grid* grid;
    ty_grid_view view;
    slice_range* slices;
    float* rows;
    uint8_t* uniform; /* sparse: 1 for each block of one value */
} grid_job;

static size_t replace_nonfinite_halves(uint16_t* values, size_t count) {
    size_t replaced = 0;
    for (size_t i = 0; i < count; ++i) {
        const bool bad = (values[i] & 0x7c00u) == 0x7c00u;
        values[i] = bad ? 0 : values[i];
        replaced += bad;
    }
    return replaced;
}

static size_t replace_nonfinite_floats(float* values, size_t count) {
    size_t replaced = 0;
    for (size_t i = 0; i < count; ++i) {
        const bool bad = (ty_bits_from_float(values[i]) & 0x7f800000u) == 0x7f800000u;
        values[i] = bad ? 0 : values[i];
        replaced += bad;
    }
    return replaced;
}

static bool all_finite(const ty_grid* grid, size_t start, size_t count) {
    const uint16_t* halves = (const uint16_t*)grid->values + start;
    const float* floats = (const float*)grid->values + start;
    uint32_t bad = 0;
    if (grid->type == TY_GRID_F16)
        for (size_t i = 0; i < count; ++i) bad |= (halves[i] & 0x7c00u) == 0x7c00u;
    else
        for (size_t i = 0; i < count; ++i) bad |= (ty_bits_from_float(floats[i]) & 0x7f800000u) == 0x7f800000u;
    return bad == 0;
}

static size_t replace_nonfinite(const ty_grid* grid, size_t start, size_t count) {
    if (grid->release != NULL) return 0; /* all are finite, and the memory may be read-only */
    if (grid->blocks.mapping != NULL && all_finite(grid, start, count)) return 0; /* pages stay as the file has them */
    return grid->type == TY_GRID_F16 ? replace_nonfinite_halves((uint16_t*)grid->values + start, count)
                                     : replace_nonfinite_floats((float*)grid->values + start, count);
}

/* Stored values from `start` on as floats: the storage itself, or converted into buffer. */
static const float* floats_of(const ty_grid* grid, size_t start, int32_t count, float* buffer) {
    if (grid->type == TY_GRID_F32) return (const float*)grid->values + start;
    const uint16_t* halves = (const uint16_t*)grid->values + start;
    for (int32_t i = 0; i < count; ++i) buffer[i] = ty_half_to_float(halves[i]);
    return buffer;
}

static void fold_values(const float* values, int32_t count, float background, slice_range* range) {
    float low = range->min, high = range->max;
    double sum = range->sum;
    int32_t active = 0;
#pragma omp simd reduction(min : low) reduction(max : high) reduction(+ : active)
    for (int32_t i = 0; i < count; ++i) {
        low = values[i] < low ? values[i] : low;
        high = values[i] > high ? values[i] : high;
        active += values[i] != background;
    }
    for (int32_t i = 0; i < count; ++i) sum += (double)values[i];
    range->min = low;
    range->max = high;
    range->sum = sum;
    range->active += active;
}

static size_t row_start(const ty_grid* grid, int32_t j, int32_t k) {
    return (size_t)grid->size[0] * ((size_t)j + (size_t)grid->size[1] * (size_t)k);
}

/* ---- dense grids ---- */

/* Replaces NaN and Inf by 0, then computes the extremes and the sum, in voxel order. */
static void compute_slice_range(void* user, int64_t k, int32_t worker) {
    const grid_job* job = user;
    const ty_grid* grid = job->grid;
    const size_t nx = (size_t)grid->size[0];
    slice_range range = {.min = TY_FLOAT_MAX, .max = -TY_FLOAT_MAX};
    for (int32_t j = 0; j < grid->size[1]; ++j) {
        const size_t start = row_start(grid, j, (int32_t)k);
        range.replaced += replace_nonfinite(grid, start, nx);
        const float* row = floats_of(grid, start, grid->size[0], job->rows + 3 * nx * (size_t)worker);
        fold_values(row, grid->size[0], grid->background, &range);
    }
    job->slices[k] = range;
}

static void fold_row(const float* row, int32_t count, float* low, float* high) {
    for (int32_t i = 0; i < count; ++i) {
        low[i] = ty_minf(low[i], row[i]);
        high[i] = ty_maxf(high[i], row[i]);
    }
}

static int32_t clamp_index(int32_t index, int32_t size) {
    return index < 0 ? 0 : index >= size ? size - 1 : index;
}

/* Extremes over the rows of the bricks (j, k), per voxel along x; returns true if they include rows outside a placed
 * grid, where the background counts. */
static bool fold_rows(const ty_grid* grid, int32_t bj, int32_t bk, float* low, float* high, float* buffer) {
    bool beyond = false;
    for (int32_t i = 0; i < grid->size[0]; ++i) {
        low[i] = TY_FLOAT_MAX;
        high[i] = -TY_FLOAT_MAX;
    }
    for (int32_t k = TY_BRICK * bk - 1; k <= TY_BRICK * (bk + 1) - 1; ++k)
        for (int32_t j = TY_BRICK * bj - 1; j <= TY_BRICK * (bj + 1) - 1; ++j) {
            const int32_t row = clamp_index(j, grid->size[1]), slice = clamp_index(k, grid->size[2]);
            if (grid->placed && (row != j || slice != k))
                beyond = true;
            else
                fold_row(floats_of(grid, row_start(grid, row, slice), grid->size[0], buffer), grid->size[0], low, high);
        }
    return beyond;
}

/* One row of bricks along x (item = j + bricks[1] * k). */
static void brick_row(void* user, int64_t item, int32_t worker) {
    const grid_job* job = user;
    const ty_grid* grid = job->grid;
    const int32_t nx = grid->size[0];
    float* low = job->rows + 3 * (size_t)nx * (size_t)worker;
    float* high = low + nx;
    const bool beyond =
        fold_rows(grid, (int32_t)(item % grid->bricks[1]), (int32_t)(item / grid->bricks[1]), low, high, high + nx);
    for (int32_t bi = 0; bi < grid->bricks[0]; ++bi) {
        const int32_t first = TY_BRICK * bi - 1, last = TY_BRICK * (bi + 1) - 1;
        const bool background = grid->placed && (beyond || first < 0 || last >= nx);
        float* pair = grid->extremes + 2 * (bi + (size_t)grid->bricks[0] * (size_t)item);
        pair[0] = background ? grid->background : TY_FLOAT_MAX;
        pair[1] = background ? grid->background : -TY_FLOAT_MAX;
        for (int32_t i = clamp_index(first, nx); i <= clamp_index(last, nx); ++i) {
            pair[0] = ty_minf(pair[0], low[i]);
            pair[1] = ty_maxf(pair[1], high[i]);
        }
    }
}

/* ---- sparse grids ---- */

enum { BLOCKS_A_TASK = 1024 };

/* The value of a block's first voxel. */
static float first_value(const ty_grid* grid, uint32_t block) {
    float buffer;
    return *floats_of(grid, (size_t)block * TY_GRID_BLOCK_VOXELS, 1, &buffer);
}

static bool is_uniform(const ty_grid* grid, size_t block) {
    const size_t value = ty_grid_value_size(grid->type), bytes = TY_GRID_BLOCK_VOXELS * value;
    const uint8_t* from = (const uint8_t*)grid->values + bytes * block;
    return memcmp(from, from + value, bytes - value) == 0;
}

static void survey_blocks(void* user, int64_t task, int32_t worker) {
    const grid_job* job = user;
    const size_t first = (size_t)BLOCKS_A_TASK * (size_t)task, left = (size_t)job->grid->blocks.count - first;
    const size_t count = left < BLOCKS_A_TASK ? left : BLOCKS_A_TASK;
    (void)worker;
    job->slices[task].replaced =
        replace_nonfinite(job->grid, first * TY_GRID_BLOCK_VOXELS, count * TY_GRID_BLOCK_VOXELS);
    for (size_t block = first; block < first + count; ++block) job->uniform[block] = is_uniform(job->grid, block);
}

/* The block after the last one that goes on as block b of a row of the table does, if it is of one value. */
static int32_t segment_end(const grid_job* job, const uint32_t* row, int32_t b) {
    int32_t end = b + 1;
    while (end < job->grid->blocks.size[0] && row[end] == row[b] && job->uniform[row[b]] != 0) ++end;
    return end;
}

static void fold_uniform(float value, int64_t count, float background, slice_range* range) {
    range->min = ty_minf(range->min, value);
    range->max = ty_maxf(range->max, value);
    range->sum += (double)value * (double)count;
    if (value != background) range->active += count;
}

/* Row (j, k) of voxels, whose blocks are those of a row of the table. */
static void fold_blocks_of_row(const grid_job* job, const uint32_t* row, int32_t j, int32_t k, slice_range* range) {
    const ty_grid* grid = job->grid;
    const int32_t shift = grid->blocks.shift[0], nx = grid->size[0];
    int32_t end;
    for (int32_t b = 0; b < grid->blocks.size[0]; b = end) {
        end = segment_end(job, row, b);
        const int32_t first = TY_GRID_BLOCK * b > shift ? TY_GRID_BLOCK * b - shift : 0;
        const int32_t last = TY_GRID_BLOCK * end - shift < nx ? TY_GRID_BLOCK * end - shift : nx;
        if (job->uniform[row[b]] != 0) {
            fold_uniform(first_value(grid, row[b]), last - first, grid->background, range);
            continue;
        }
        float buffer[TY_GRID_BLOCK];
        const size_t at = ty_grid_offset(&job->view, first, j, k);
        fold_values(floats_of(grid, at, last - first, buffer), last - first, grid->background, range);
    }
}

static void compute_sparse_slice(void* user, int64_t k, int32_t worker) {
    const grid_job* job = user;
    const ty_grid* grid = job->grid;
    const ty_grid_blocks* blocks = &grid->blocks;
    const size_t slab = (size_t)blocks->size[1] * (size_t)((k + blocks->shift[2]) / TY_GRID_BLOCK);
    slice_range range = {.min = TY_FLOAT_MAX, .max = -TY_FLOAT_MAX};
    (void)worker;
    for (int32_t b = 0; b < blocks->size[1]; ++b) {
        const uint32_t* row = blocks->table + (size_t)blocks->size[0] * (slab + (size_t)b);
        const int32_t first = clamp_index(TY_GRID_BLOCK * b - blocks->shift[1], grid->size[1]);
        const int32_t last = clamp_index(TY_GRID_BLOCK * (b + 1) - 1 - blocks->shift[1], grid->size[1]);
        if (job->uniform[row[0]] != 0 && segment_end(job, row, 0) == blocks->size[0])
            fold_uniform(first_value(grid, row[0]), (int64_t)grid->size[0] * (last - first + 1), grid->background,
                         &range);
        else
            for (int32_t j = first; j <= last; ++j) fold_blocks_of_row(job, row, j, (int32_t)k, &range);
    }
    job->slices[k] = range;
}

/* Blocks that voxels first..last reach into, as far as they lie in the grid: low..high along each axis. */
static void find_blocks(const ty_grid* grid, const int32_t first[3], const int32_t last[3], int32_t low[3],
                        int32_t high[3]) {
    for (int a = 0; a < 3; ++a) {
        low[a] = (clamp_index(first[a], grid->size[a]) + grid->blocks.shift[a]) >> TY_GRID_BLOCK_LOG2;
        high[a] = (clamp_index(last[a], grid->size[a]) + grid->blocks.shift[a]) >> TY_GRID_BLOCK_LOG2;
    }
}

static uint32_t block_at(const ty_grid_blocks* blocks, int32_t i, int32_t j, int32_t k) {
    const size_t row = (size_t)j + (size_t)blocks->size[1] * (size_t)k;
    return blocks->table[(size_t)blocks->size[0] * row + (size_t)i];
}

bool ty_grid_is_common(const ty_grid* grid, const int32_t first[3], const int32_t last[3], float* value) {
    int32_t low[3], high[3];
    if (grid->blocks.table == NULL) return false;
    find_blocks(grid, first, last, low, high);
    for (int32_t k = low[2]; k <= high[2]; ++k)
        for (int32_t j = low[1]; j <= high[1]; ++j)
            for (int32_t i = low[0]; i <= high[0]; ++i)
                if (block_at(&grid->blocks, i, j, k) != 0) return false;
    *value = first_value(grid, 0);
    return true;
}

/* Folds the blocks that voxels first..last reach into; false if one of them is not of one value. */
static bool fold_uniform_blocks(const grid_job* job, const int32_t first[3], const int32_t last[3], float pair[2]) {
    int32_t low[3], high[3];
    find_blocks(job->grid, first, last, low, high);
    for (int32_t k = low[2]; k <= high[2]; ++k)
        for (int32_t j = low[1]; j <= high[1]; ++j)
            for (int32_t i = low[0]; i <= high[0]; ++i) {
                const uint32_t block = block_at(&job->grid->blocks, i, j, k);
                if (job->uniform[block] == 0) return false;
                const float value = first_value(job->grid, block);
                pair[0] = ty_minf(pair[0], value);
                pair[1] = ty_maxf(pair[1], value);
            }
    return true;
}

static void fold_brick(const ty_grid_view* view, const int32_t first[3], const int32_t last[3], float pair[2]) {
    for (int32_t k = first[2]; k <= last[2]; ++k)
        for (int32_t j = first[1]; j <= last[1]; ++j)
            for (int32_t i = first[0]; i <= last[0]; ++i) {
                const float value = ty_grid_fetch(view, i, j, k);
                pair[0] = ty_minf(pair[0], value);
                pair[1] = ty_maxf(pair[1], value);
            }
}

/* The same as brick_row. */
static void sparse_brick_row(void* user, int64_t item, int32_t worker) {
    const grid_job* job = user;
    const ty_grid* grid = job->grid;
    const int32_t brick[3] = {0, (int32_t)(item % grid->bricks[1]), (int32_t)(item / grid->bricks[1])};
    (void)worker;
    for (int32_t bi = 0; bi < grid->bricks[0]; ++bi) {
        int32_t first[3], last[3];
        bool beyond = false;
        for (int a = 0; a < 3; ++a) {
            first[a] = TY_BRICK * (a == 0 ? bi : brick[a]) - 1;
            last[a] = first[a] + TY_BRICK;
            beyond = beyond || first[a] < 0 || last[a] >= grid->size[a];
        }
        float* pair = grid->extremes + 2 * ((size_t)bi + (size_t)grid->bricks[0] * (size_t)item);
        const bool background = grid->placed && beyond;
        pair[0] = background ? grid->background : TY_FLOAT_MAX;
        pair[1] = background ? grid->background : -TY_FLOAT_MAX;
        if (fold_uniform_blocks(job, first, last, pair)) continue;
        pair[0] = TY_FLOAT_MAX;
        pair[1] = -TY_FLOAT_MAX;
        fold_brick(&job->view, first, last, pair);
    }
}

/* ---- both ---- */

static void sum_slices(ty_grid* grid, const slice_range* slices, size_t replaced) {
    double sum = 0;
    grid->min = TY_FLOAT_MAX;
    grid->max = -TY_FLOAT_MAX;
    for (int32_t k = 0; k < grid->size[2]; ++k) {
        grid->min = ty_minf(grid->min, slices[k].min);
        grid->max = ty_maxf(grid->max, slices[k].max);
        sum += slices[k].sum;
        grid->active += slices[k].active;
        replaced += slices[k].replaced;
    }
    grid->mean = sum / (double)grid->voxels;
    if (replaced > 0)
        ty_log(grid->context, TY_LOG_WARNING, "a grid had %zu values that are not finite; they count as 0", replaced);
}

static size_t survey_all_blocks(grid_job* job, size_t tasks) {
    size_t replaced = 0;
    ty_parallel_for(job->grid->context, (int64_t)tasks, survey_blocks, job);
    for (size_t i = 0; i < tasks; ++i) {
        replaced += job->slices[i].replaced;
        job->slices[i].replaced = 0;
    }
    return replaced;
}

ty_result ty_grid_measure(ty_grid* grid) {
    ty_context* context = grid->context;
    const bool sparse = grid->blocks.table != NULL;
    const size_t tasks = sparse ? ((size_t)grid->blocks.count + BLOCKS_A_TASK - 1) / BLOCKS_A_TASK : 0;
    const size_t slices = tasks > (size_t)grid->size[2] ? tasks : (size_t)grid->size[2];
    const size_t floats = sparse ? 0 : 3 * (size_t)grid->size[0] * (size_t)ty_context_threads(context);
    grid_job job = {.grid = grid,
                    .view = ty_grid_get_view(grid),
                    .slices = ty_alloc_array(context, slices, sizeof *job.slices, true),
                    .rows = ty_alloc_array(context, floats, sizeof *job.rows, false),
                    .uniform = ty_alloc_array(context, grid->blocks.count, 1, false)};
    const bool allocated = job.slices != NULL && job.rows != NULL && job.uniform != NULL;
    if (allocated) {
        const size_t replaced = survey_all_blocks(&job, tasks);
        ty_parallel_for(context, grid->size[2], sparse ? compute_sparse_slice : compute_slice_range, &job);
        sum_slices(grid, job.slices, replaced);
        ty_parallel_for(context, (int64_t)grid->bricks[1] * grid->bricks[2], sparse ? sparse_brick_row : brick_row,
                        &job);
    }
    ty_free_array(context, job.slices, slices, sizeof *job.slices);
    ty_free_array(context, job.rows, floats, sizeof *job.rows);
    ty_free_array(context, job.uniform, grid->blocks.count, 1);
    return allocated ? TY_OK : TY_ERROR_MEMORY;
}
