/* Dense grids: creation, extremes per brick, sampling. */
#include "grid/grid.h"

#include "base/context.h"
#include "grid/lookup.k.h"

#include <stdatomic.h>

void ty_init_grid_def(void* def, size_t bytes) {
    const ty_grid_def own = {.type = TY_GRID_F32, .index_to_local = ty_affine_identity()};
    ty_init_def(def, bytes, &own, sizeof own);
}

size_t ty_grid_value_size(ty_grid_type type) {
    return type == TY_GRID_F16 ? sizeof(uint16_t) : sizeof(float);
}

static ty_result check_def(ty_context* context, const ty_grid_def** given, ty_grid_def* own) {
    *own = ty_default_grid_def();
    const ty_result result = ty_take_def(context, *given, "ty_default_grid_def", own, sizeof *own);
    const ty_grid_def* def = *given = own;
    if (result != TY_OK) return result;
    for (int a = 0; a < 3; ++a)
        if (def->size[a] < 1 || def->size[a] > TY_GRID_SIDE_MAX)
            return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's size along %c is %d, outside 1..%d", "xyz"[a],
                           def -> size[a], TY_GRID_SIDE_MAX);
    if (def->type != TY_GRID_F32 && def->type != TY_GRID_F16)
        return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's type is %d, not a ty_grid_type", (int)def->type);
    ty_affine inverse;
    if (!ty_affine_invert(&def->index_to_local, &inverse))
        return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's index_to_local cannot be inverted");
    if (!isfinite(def->background)) return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's background is not finite");
    return TY_OK;
}

/* Extremes and sum of a slice of voxels, and its number of non-finite values. */
typedef struct slice_range {
    float min, max;
    double sum;
    size_t replaced;
} slice_range;

/* Arguments of the loops: the grid, a result per slice, and buffers of one or more rows of floats per worker. */
typedef struct grid_job {
    ty_grid* grid;
    slice_range* slices;
    float* rows;
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

static size_t row_start(const ty_grid* grid, int32_t j, int32_t k) {
    return (size_t)grid->size[0] * ((size_t)j + (size_t)grid->size[1] * (size_t)k);
}

/* A row of voxels as floats: the storage itself, or converted into buffer. */
static const float* row_of(const ty_grid* grid, int32_t j, int32_t k, float* buffer) {
    if (grid->type == TY_GRID_F32) return (const float*)grid->values + row_start(grid, j, k);
    const uint16_t* halves = (const uint16_t*)grid->values + row_start(grid, j, k);
    for (int32_t i = 0; i < grid->size[0]; ++i) buffer[i] = ty_half_to_float(halves[i]);
    return buffer;
}

static size_t replace_nonfinite(const ty_grid* grid, size_t start, size_t count) {
    if (grid->release != NULL) return 0; /* all are finite, and the memory may be read-only */
    return grid->type == TY_GRID_F16 ? replace_nonfinite_halves((uint16_t*)grid->values + start, count)
                                     : replace_nonfinite_floats((float*)grid->values + start, count);
}

/* Replaces NaN and Inf by 0, then computes the extremes and the sum, in voxel order. */
static void compute_slice_range(void* user, int64_t k, int32_t worker) {
    const grid_job* job = user;
    const ty_grid* grid = job->grid;
    const size_t nx = (size_t)grid->size[0];
    slice_range range = {.min = TY_FLOAT_MAX, .max = -TY_FLOAT_MAX};
    for (int32_t j = 0; j < grid->size[1]; ++j) {
        const size_t start = row_start(grid, j, (int32_t)k);
        range.replaced += replace_nonfinite(grid, start, nx);
        const float* row = row_of(grid, j, (int32_t)k, job->rows + 3 * nx * (size_t)worker);
        float low = range.min, high = range.max;
        double sum = range.sum;
#pragma omp simd reduction(min : low) reduction(max : high)
        for (size_t i = 0; i < nx; ++i) {
            low = row[i] < low ? row[i] : low;
            high = row[i] > high ? row[i] : high;
        }
        for (size_t i = 0; i < nx; ++i) sum += row[i];
        range.min = low;
        range.max = high;
        range.sum = sum;
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
                fold_row(row_of(grid, row, slice, buffer), grid->size[0], low, high);
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

static void sum_slices(ty_grid* grid, const slice_range* slices) {
    size_t replaced = 0;
    double sum = 0;
    grid->min = TY_FLOAT_MAX;
    grid->max = -TY_FLOAT_MAX;
    for (int32_t k = 0; k < grid->size[2]; ++k) {
        grid->min = ty_minf(grid->min, slices[k].min);
        grid->max = ty_maxf(grid->max, slices[k].max);
        sum += slices[k].sum;
        replaced += slices[k].replaced;
    }
    grid->mean = sum / (double)grid->voxels;
    if (replaced > 0)
        ty_log(grid->context, TY_LOG_WARNING, "a grid had %zu values that are not finite; they count as 0", replaced);
}

/* Replaces non-finite values, then computes the range and the bricks' extremes. */
static ty_result compute_extremes(ty_grid* grid) {
    ty_context* context = grid->context;
    const size_t slices = (size_t)grid->size[2];
    const size_t floats = 3 * (size_t)grid->size[0] * (size_t)ty_context_threads(context);
    grid_job job = {.grid = grid,
                    .slices = ty_alloc_array(context, slices, sizeof *job.slices, false),
                    .rows = ty_alloc_array(context, floats, sizeof *job.rows, false)};
    const bool allocated = job.slices != NULL && job.rows != NULL;
    if (allocated) {
        ty_parallel_for(context, grid->size[2], compute_slice_range, &job);
        sum_slices(grid, job.slices);
        ty_parallel_for(context, (int64_t)grid->bricks[1] * grid->bricks[2], brick_row, &job);
    }
    ty_free_array(context, job.slices, slices, sizeof *job.slices);
    ty_free_array(context, job.rows, floats, sizeof *job.rows);
    return allocated ? TY_OK : TY_ERROR_MEMORY;
}

static size_t brick_count(const ty_grid* grid) {
    return (size_t)grid->bricks[0] * (size_t)grid->bricks[1] * (size_t)grid->bricks[2];
}

/* A grid of values that are borrowed if def->release is not NULL, and else its own; these are freed on failure. */
static ty_result create_grid(ty_context* context, const ty_grid_def* def, void* values, ty_grid** out) {
    const size_t voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
    const size_t bytes = ty_grid_value_size(def->type);
    ty_grid_def own;
    ty_result result = check_def(context, &def, &own);
    ty_grid* grid = result == TY_OK ? ty_alloc_array(context, 1, sizeof *grid, true) : NULL;
    if (grid == NULL) {
        if (def->release == NULL) ty_free_array(context, values, voxels, bytes);
        return result == TY_OK ? TY_ERROR_MEMORY : result;
    }
    grid->context = context;
    atomic_init(&grid->owners, 1);
    memcpy(grid->size, def->size, sizeof grid->size);
    grid->type = def->type;
    grid->placed = def->placed;
    grid->background = def->background;
    grid->index_to_local = def->index_to_local;
    grid->release = def->release;
    grid->release_user = def->release_user;
    grid->voxels = voxels;
    grid->values = values != NULL ? values : ty_alloc_array(context, voxels, bytes, true);
    for (int a = 0; a < 3; ++a) grid->bricks[a] = (def->size[a] + TY_BRICK) / TY_BRICK;
    grid->extremes = ty_alloc_array(context, brick_count(grid), 2 * sizeof(float), false);
    if (grid->values == NULL || grid->extremes == NULL || compute_extremes(grid) != TY_OK) {
        grid->release = NULL; /* a failure leaves borrowed values to the caller */
        if (def->release != NULL) grid->values = NULL;
        ty_grid_release(grid);
        return TY_ERROR_MEMORY;
    }
    *out = grid;
    return TY_OK;
}

ty_result ty_grid_adopt(ty_context* context, const ty_grid_def* def, void* values, ty_grid** out) {
    ty_grid_def own = *def;
    own.release = NULL;
    return create_grid(context, &own, values, out);
}

/* ---- borrowed values ---- */

typedef struct finite_job {
    const ty_grid_def* def;
    _Atomic bool all_finite;
} finite_job;

static void check_finite_slice(void* user, int64_t k, int32_t worker) {
    finite_job* job = user;
    const size_t count = (size_t)job->def->size[0] * (size_t)job->def->size[1], start = count * (size_t)k;
    const float* floats = (const float*)job->def->values + start;
    const uint16_t* halves = (const uint16_t*)job->def->values + start;
    uint32_t bad = 0;
    (void)worker;
    if (job->def->type == TY_GRID_F16)
        for (size_t i = 0; i < count; ++i) bad |= (halves[i] & 0x7c00u) == 0x7c00u;
    else
        for (size_t i = 0; i < count; ++i) bad |= (ty_bits_from_float(floats[i]) & 0x7f800000u) == 0x7f800000u;
    if (bad != 0) atomic_store(&job->all_finite, false);
}

static bool is_finite(ty_context* context, const ty_grid_def* def) {
    finite_job job = {.def = def, .all_finite = true};
    ty_parallel_for(context, def->size[2], check_finite_slice, &job);
    return atomic_load(&job.all_finite);
}

/* The borrowed values as a grid; where some are not finite, a copy, and the loan ends. */
static ty_result borrow_values(ty_context* context, const ty_grid_def* def, ty_grid** out) {
    if (def->values == NULL || (uintptr_t)def->values % ty_grid_value_size(def->type) != 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's borrowed values are NULL, or not aligned to their size");
    if (is_finite(context, def)) return create_grid(context, def, (void*)def->values, out);
    ty_grid_def copied = *def;
    copied.release = NULL;
    const ty_result result = ty_grid_create(context, &copied, out);
    if (result == TY_OK) def->release(def->release_user);
    return result;
}

ty_result ty_grid_create(ty_context* context, const ty_grid_def* def, ty_grid** out) {
    ty_grid_def own;
    const ty_result result = check_def(context, &def, &own);
    if (result != TY_OK) return result;
    if (def->release != NULL) return borrow_values(context, def, out);
    void* values = NULL;
    if (def->values != NULL) {
        const size_t voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
        const size_t bytes = ty_grid_value_size(def->type);
        values = ty_alloc_array(context, voxels, bytes, false);
        if (values == NULL) return TY_ERROR_MEMORY;
        memcpy(values, def->values, voxels * bytes);
    }
    return create_grid(context, def, values, out);
}

ty_grid* ty_grid_retain(ty_grid* grid) {
    if (grid != NULL) atomic_fetch_add(&grid->owners, 1);
    return grid;
}

void ty_grid_release(ty_grid* grid) {
    if (grid == NULL || atomic_fetch_sub(&grid->owners, 1) > 1) return;
    ty_context* context = grid->context;
    if (grid->release != NULL)
        grid->release(grid->release_user);
    else
        ty_free_array(context, grid->values, grid->voxels, ty_grid_value_size(grid->type));
    ty_free_array(context, grid->extremes, brick_count(grid), 2 * sizeof(float));
    ty_free_array(context, grid, 1, sizeof *grid);
}

ty_grid_info ty_grid_get_info(const ty_grid* grid) {
    return (ty_grid_info){
        .size = {grid->size[0], grid->size[1], grid->size[2]},
        .type = grid->type,
        .placed = grid->placed,
        .background = grid->background,
        .min = grid->min,
        .max = grid->max,
        .mean = grid->mean,
        .bytes = sizeof *grid + grid->voxels * ty_grid_value_size(grid->type) + brick_count(grid) * 2 * sizeof(float),
        .index_to_local = grid->index_to_local,
    };
}

const void* ty_grid_values(const ty_grid* grid) {
    return grid->values;
}

float ty_grid_sample(const ty_grid* grid, const double index[3]) {
    const ty_grid_view view = ty_grid_get_view(grid);
    int32_t base[3];
    float weight[3];
    for (int a = 0; a < 3; ++a) {
        const double x = fmin(fmax(index[a], -1.0), (double)grid->size[a]);
        base[a] = (int32_t)floor(x);
        weight[a] = (float)(x - base[a]);
    }
    return ty_grid_trilinear(&view, base, weight);
}

float ty_grid_voxel(const ty_grid* grid, int32_t i, int32_t j, int32_t k) {
    const ty_grid_view view = ty_grid_get_view(grid);
    return ty_grid_fetch(&view, i, j, k);
}
