/* Grids: creation, properties, sampling. */
#include "grid/grid.h"

#include "base/context.h"
#include "base/mapping.h"
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

size_t ty_grid_brick_count(const ty_grid* grid) {
    return (size_t)grid->bricks[0] * (size_t)grid->bricks[1] * (size_t)grid->bricks[2];
}

size_t ty_grid_table_count(const ty_grid_blocks* blocks) {
    return (size_t)blocks->size[0] * (size_t)blocks->size[1] * (size_t)blocks->size[2];
}

void* ty_grid_blocks_values(ty_context* context, ty_grid_type type, bool paged, ty_grid_blocks* blocks,
                            ty_result* result) {
    const size_t stored = (size_t)blocks->count * TY_GRID_BLOCK_VOXELS, bytes = ty_grid_value_size(type);
    if (!paged) {
        void* values = ty_alloc_array(context, stored, bytes, false);
        *result = values != NULL ? TY_OK : TY_ERROR_MEMORY;
        return values;
    }
    *result = ty_mapping_create(context, stored * bytes, &blocks->mapping);
    return *result == TY_OK ? blocks->mapping->bytes : NULL;
}

static void free_values(ty_context* context, ty_grid_type type, ty_grid_blocks* blocks, void* values, size_t stored) {
    if (blocks->mapping == NULL) ty_free_array(context, values, stored, ty_grid_value_size(type));
    if (!blocks->maps_tables) ty_free_array(context, blocks->table, ty_grid_table_count(blocks), sizeof *blocks->table);
    ty_mapping_close(blocks->mapping);
    blocks->mapping = NULL;
    blocks->table = NULL;
}

void ty_grid_free_blocks(ty_context* context, ty_grid_type type, ty_grid_blocks* blocks, void* values) {
    free_values(context, type, blocks, values, (size_t)blocks->count * TY_GRID_BLOCK_VOXELS);
}

static void set_def(ty_grid* grid, const ty_grid_def* def) {
    atomic_init(&grid->owners, 1);
    memcpy(grid->size, def->size, sizeof grid->size);
    grid->type = def->type;
    grid->placed = def->placed;
    grid->background = def->background;
    grid->index_to_local = def->index_to_local;
    grid->voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
    for (int a = 0; a < 3; ++a) grid->bricks[a] = (def->size[a] + TY_BRICK) / TY_BRICK;
}

/* A grid of values that are borrowed if def->release is not NULL, and else its own; these are freed on failure, as the
 * table of blocks is, where there is one. */
static ty_result create_grid(ty_context* context, const ty_grid_def* def, ty_grid_blocks* blocks, void* values,
                             ty_grid** out) {
    const size_t voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
    const size_t stored = blocks->table != NULL ? (size_t)blocks->count * TY_GRID_BLOCK_VOXELS : voxels;
    const size_t bytes = ty_grid_value_size(def->type);
    ty_grid_def own;
    ty_result result = check_def(context, &def, &own);
    ty_grid* grid = result == TY_OK ? ty_alloc_array(context, 1, sizeof *grid, true) : NULL;
    if (grid == NULL) {
        free_values(context, def->type, blocks, def->release == NULL ? values : NULL, stored);
        return result == TY_OK ? TY_ERROR_MEMORY : result;
    }
    set_def(grid, def);
    grid->context = context;
    grid->release = def->release;
    grid->release_user = def->release_user;
    grid->stored = stored;
    grid->blocks = *blocks;
    grid->values = values != NULL ? values : ty_alloc_array(context, stored, bytes, true);
    grid->extremes = ty_alloc_array(context, ty_grid_brick_count(grid), 2 * sizeof(float), false);
    if (grid->values == NULL || grid->extremes == NULL || ty_grid_measure(grid) != TY_OK) {
        grid->release = NULL; /* a failure leaves borrowed values to the caller */
        if (def->release != NULL) grid->values = NULL;
        ty_grid_release(grid);
        return TY_ERROR_MEMORY;
    }
    if (grid->blocks.mapping != NULL) ty_mapping_expect_random(grid->blocks.mapping);
    *out = grid;
    return TY_OK;
}

static ty_result create_dense(ty_context* context, const ty_grid_def* def, void* values, ty_grid** out) {
    ty_grid_blocks none = {.table = NULL};
    return create_grid(context, def, &none, values, out);
}

ty_result ty_grid_adopt(ty_context* context, const ty_grid_def* def, void* values, ty_grid** out) {
    ty_grid_def own = *def;
    own.release = NULL;
    return create_dense(context, &own, values, out);
}

ty_result ty_grid_adopt_blocks(ty_context* context, const ty_grid_def* def, ty_grid_blocks* blocks, void* values,
                               ty_grid** out) {
    ty_grid_def own = *def;
    own.release = NULL;
    return create_grid(context, &own, blocks, values, out);
}

ty_result ty_grid_adopt_mapping(ty_context* context, const ty_grid_def* def, const ty_grid_blocks* blocks,
                                const void* values, const float* extremes, const ty_grid_measured* measured,
                                ty_grid** out) {
    ty_grid_def own;
    ty_result result = check_def(context, &def, &own);
    ty_grid* grid = result == TY_OK ? ty_alloc_array(context, 1, sizeof *grid, true) : NULL;
    if (result == TY_OK && grid == NULL) result = TY_ERROR_MEMORY;
    if (result != TY_OK) {
        ty_mapping_close(blocks->mapping);
        return result;
    }
    set_def(grid, def);
    grid->context = context;
    grid->stored = (size_t)blocks->count * TY_GRID_BLOCK_VOXELS;
    grid->blocks = *blocks;
    grid->blocks.maps_tables = true;
    grid->values = (void*)values;
    grid->extremes = (float*)extremes;
    grid->min = measured->min;
    grid->max = measured->max;
    grid->mean = measured->mean;
    grid->active = measured->active;
    ty_mapping_expect_random(blocks->mapping);
    *out = grid;
    return TY_OK;
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
    if (is_finite(context, def)) return create_dense(context, def, (void*)def->values, out);
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
    return create_dense(context, def, values, out);
}

ty_grid* ty_grid_retain(ty_grid* grid) {
    if (grid != NULL) atomic_fetch_add(&grid->owners, 1);
    return grid;
}

void ty_grid_release(ty_grid* grid) {
    if (grid == NULL || atomic_fetch_sub(&grid->owners, 1) > 1) return;
    ty_context* context = grid->context;
    if (grid->release != NULL) grid->release(grid->release_user);
    if (!grid->blocks.maps_tables) ty_free_array(context, grid->extremes, ty_grid_brick_count(grid), 2 * sizeof(float));
    free_values(context, grid->type, &grid->blocks, grid->release == NULL ? grid->values : NULL, grid->stored);
    ty_free_array(context, grid, 1, sizeof *grid);
}

static ty_grid_storage storage_of(const ty_grid* grid) {
    if (grid->blocks.mapping != NULL) return TY_GRID_PAGED;
    return grid->blocks.table != NULL ? TY_GRID_SPARSE : TY_GRID_DENSE;
}

ty_grid_info ty_grid_get_info(const ty_grid* grid) {
    const size_t in_memory = grid->blocks.mapping == NULL ? grid->stored : 0;
    return (ty_grid_info){
        .size = {grid->size[0], grid->size[1], grid->size[2]},
        .type = grid->type,
        .placed = grid->placed,
        .background = grid->background,
        .min = grid->min,
        .max = grid->max,
        .mean = grid->mean,
        .bytes = sizeof *grid + in_memory * ty_grid_value_size(grid->type) +
                 ty_grid_table_count(&grid->blocks) * sizeof *grid->blocks.table +
                 ty_grid_brick_count(grid) * 2 * sizeof(float),
        .index_to_local = grid->index_to_local,
        .storage = storage_of(grid),
        .active = grid->active,
        .stored = (int64_t)grid->stored,
    };
}

const void* ty_grid_values(const ty_grid* grid) {
    return grid->blocks.table != NULL ? NULL : grid->values;
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
