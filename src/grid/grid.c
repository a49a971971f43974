/* Dense grids: creation, extremes over bricks, sampling. */
#include "grid/grid.h"

#include "base/context.h"
#include "grid/lookup.k.h"

#include <stdatomic.h>

enum { SIZE_MAX_AXIS = 16384 };

ty_grid_def ty_default_grid_def(void) {
    return (ty_grid_def){.cookie = TY_DEF_COOKIE, .type = TY_GRID_F32, .index_to_local = ty_affine_identity()};
}

static size_t value_size(ty_grid_type type) {
    return type == TY_GRID_F16 ? sizeof(uint16_t) : sizeof(float);
}

static ty_result check_def(ty_context* context, const ty_grid_def* def) {
    const ty_result result = ty_check_def(context, def, "ty_default_grid_def");
    if (result != TY_OK) return result;
    for (int a = 0; a < 3; ++a)
        if (def->size[a] < 1 || def->size[a] > SIZE_MAX_AXIS)
            return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's size along %c is %d, outside 1..%d", "xyz"[a],
                           def -> size[a], SIZE_MAX_AXIS);
    if (def->type != TY_GRID_F32 && def->type != TY_GRID_F16)
        return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's type is %d, not a ty_grid_type", (int)def->type);
    ty_affine inverse;
    if (!ty_affine_invert(&def->index_to_local, &inverse))
        return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's index_to_local cannot be inverted");
    if (!isfinite(def->background)) return ty_fail(context, TY_ERROR_ARGUMENT, "a grid's background is not finite");
    return TY_OK;
}

/* Replaces NaN and Inf by 0; returns how many there were. */
static size_t mend_values(ty_grid* grid) {
    size_t mended = 0;
    if (grid->type == TY_GRID_F16) {
        uint16_t* values = grid->values;
        for (size_t i = 0; i < grid->voxels; ++i)
            if ((values[i] & 0x7c00u) == 0x7c00u) {
                values[i] = 0;
                ++mended;
            }
    } else {
        float* values = grid->values;
        for (size_t i = 0; i < grid->voxels; ++i)
            if (!isfinite(values[i])) {
                values[i] = 0;
                ++mended;
            }
    }
    return mended;
}

/* One row of bricks along x (item = j + bricks[1] * k). */
static void brick_row(void* user, int64_t item, int32_t worker) {
    (void)worker;
    ty_grid* grid = user;
    const int32_t bj = (int32_t)(item % grid->bricks[1]), bk = (int32_t)(item / grid->bricks[1]);
    const ty_grid_view view = ty_grid_get_view(grid);
    for (int32_t bi = 0; bi < grid->bricks[0]; ++bi) {
        float low = TY_FLOAT_MAX, high = -TY_FLOAT_MAX;
        for (int32_t k = TY_BRICK * bk - 1; k <= TY_BRICK * (bk + 1) - 1; ++k)
            for (int32_t j = TY_BRICK * bj - 1; j <= TY_BRICK * (bj + 1) - 1; ++j)
                for (int32_t i = TY_BRICK * bi - 1; i <= TY_BRICK * (bi + 1) - 1; ++i) {
                    const float value = ty_grid_fetch(&view, i, j, k);
                    low = ty_minf(low, value);
                    high = ty_maxf(high, value);
                }
        float* pair = grid->extremes + 2 * (bi + (size_t)grid->bricks[0] * (size_t)item);
        pair[0] = low;
        pair[1] = high;
    }
}

/* Extremes and sum of one slice of voxels. */
typedef struct slice_range {
    float min, max;
    double sum;
} slice_range;

typedef struct range_job {
    const ty_grid* grid;
    slice_range* slices;
} range_job;

static void slice_of_range(void* user, int64_t k, int32_t worker) {
    (void)worker;
    const range_job* job = user;
    const ty_grid_view view = ty_grid_get_view(job->grid);
    slice_range range = {.min = TY_FLOAT_MAX, .max = -TY_FLOAT_MAX};
    for (int32_t j = 0; j < job->grid->size[1]; ++j)
        for (int32_t i = 0; i < job->grid->size[0]; ++i) {
            const float value = ty_grid_fetch(&view, i, j, (int32_t)k);
            range.min = ty_minf(range.min, value);
            range.max = ty_maxf(range.max, value);
            range.sum += value;
        }
    job->slices[k] = range;
}

static ty_result find_range(ty_grid* grid) {
    const size_t count = (size_t)grid->size[2];
    range_job job = {.grid = grid, .slices = ty_alloc_array(grid->context, count, sizeof *job.slices, false)};
    if (job.slices == NULL) return TY_ERROR_MEMORY;
    ty_parallel_for(grid->context, grid->size[2], slice_of_range, &job);
    grid->min = TY_FLOAT_MAX;
    grid->max = -TY_FLOAT_MAX;
    double sum = 0;
    for (size_t k = 0; k < count; ++k) {
        grid->min = ty_minf(grid->min, job.slices[k].min);
        grid->max = ty_maxf(grid->max, job.slices[k].max);
        sum += job.slices[k].sum;
    }
    grid->mean = sum / (double)grid->voxels;
    ty_free_array(grid->context, job.slices, count, sizeof *job.slices);
    return TY_OK;
}

static size_t brick_count(const ty_grid* grid) {
    return (size_t)grid->bricks[0] * (size_t)grid->bricks[1] * (size_t)grid->bricks[2];
}

ty_result ty_grid_adopt(ty_context* context, const ty_grid_def* def, void* values, ty_grid** out) {
    const size_t voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
    const size_t bytes = value_size(def->type);
    ty_result result = check_def(context, def);
    ty_grid* grid = result == TY_OK ? ty_alloc_array(context, 1, sizeof *grid, true) : NULL;
    if (grid == NULL) {
        ty_free_array(context, values, voxels, bytes);
        return result == TY_OK ? TY_ERROR_MEMORY : result;
    }
    grid->context = context;
    atomic_init(&grid->owners, 1);
    memcpy(grid->size, def->size, sizeof grid->size);
    grid->type = def->type;
    grid->placed = def->placed;
    grid->background = def->background;
    grid->index_to_local = def->index_to_local;
    grid->voxels = voxels;
    grid->values = values != NULL ? values : ty_alloc_array(context, voxels, bytes, true);
    for (int a = 0; a < 3; ++a) grid->bricks[a] = (def->size[a] + TY_BRICK) / TY_BRICK;
    grid->extremes = ty_alloc_array(context, brick_count(grid), 2 * sizeof(float), false);
    if (grid->values == NULL || grid->extremes == NULL) {
        ty_grid_destroy(grid);
        return TY_ERROR_MEMORY;
    }
    const size_t mended = mend_values(grid);
    if (mended > 0)
        ty_log(context, TY_LOG_WARNING, "a grid had %zu values that are not finite; they count as 0", mended);
    ty_parallel_for(context, (int64_t)grid->bricks[1] * grid->bricks[2], brick_row, grid);
    if (find_range(grid) != TY_OK) {
        ty_grid_destroy(grid);
        return TY_ERROR_MEMORY;
    }
    *out = grid;
    return TY_OK;
}

ty_result ty_grid_create(ty_context* context, const ty_grid_def* def, ty_grid** out) {
    const ty_result result = check_def(context, def);
    if (result != TY_OK) return result;
    void* values = NULL;
    if (def->values != NULL) {
        const size_t voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
        const size_t bytes = value_size(def->type);
        values = ty_alloc_array(context, voxels, bytes, false);
        if (values == NULL) return TY_ERROR_MEMORY;
        memcpy(values, def->values, voxels * bytes);
    }
    return ty_grid_adopt(context, def, values, out);
}

ty_grid* ty_grid_retain(ty_grid* grid) {
    if (grid != NULL) atomic_fetch_add(&grid->owners, 1);
    return grid;
}

void ty_grid_destroy(ty_grid* grid) {
    if (grid == NULL || atomic_fetch_sub(&grid->owners, 1) > 1) return;
    ty_context* context = grid->context;
    ty_free_array(context, grid->values, grid->voxels, value_size(grid->type));
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
        .bytes = sizeof *grid + grid->voxels * value_size(grid->type) + brick_count(grid) * 2 * sizeof(float),
        .index_to_local = grid->index_to_local,
    };
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
