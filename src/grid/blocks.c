/* Sparse grids: the choice of storage, and blocks from slices of voxels or another grid. */
#include "base/context.h"
#include "grid/grid.h"
#include "grid/lookup.k.h"

/* TY_GRID_AUTO chooses blocks where they save this many bytes. */
static const size_t saving_min = (size_t)16 << 20;

bool ty_grid_saves_memory(ty_grid_type type, size_t voxels, size_t table, size_t blocks) {
    const size_t dense = voxels * ty_grid_value_size(type);
    const size_t sparse = blocks * TY_GRID_BLOCK_VOXELS * ty_grid_value_size(type) + table * sizeof(uint32_t);
    return sparse <= dense / 2 && dense - sparse >= saving_min;
}

uint32_t* ty_grid_blocks_table(ty_context* context, const int32_t size[3], const int32_t shift[3],
                               ty_grid_blocks* blocks) {
    *blocks = (ty_grid_blocks){.count = 1};
    for (int a = 0; a < 3; ++a) {
        blocks->shift[a] = shift[a];
        blocks->size[a] = (size[a] + shift[a] + TY_GRID_BLOCK - 1) / TY_GRID_BLOCK;
    }
    return blocks->table = ty_alloc_array(context, ty_grid_table_count(blocks), sizeof *blocks->table, true);
}

void ty_grid_plan_blocks(const ty_grid_plan* plan, int axis, int32_t size, int32_t shift, int32_t* first,
                         int32_t* end) {
    const int32_t low = plan->part && plan->first[axis] > 0 ? plan->first[axis] : 0;
    const int32_t high = plan->part && plan->end[axis] < size ? plan->end[axis] : size;
    *first = (low + shift) / TY_GRID_BLOCK;
    *end = high > low ? (high + shift + TY_GRID_BLOCK - 1) / TY_GRID_BLOCK : *first;
}

void ty_grid_plan_rows(const ty_grid_plan* plan, int32_t size, int32_t* first, int32_t* end) {
    ty_grid_plan_blocks(plan, 1, size, 0, first, end);
    *first *= TY_GRID_BLOCK;
    *end = *end * TY_GRID_BLOCK < size ? *end * TY_GRID_BLOCK : size;
}

float ty_value_outside(ty_grid_type type, const void* values, size_t count) {
    float lowest = 0;
    for (size_t i = 0; i < count; ++i) {
        const float value =
            type == TY_GRID_F16 ? ty_half_to_float(((const uint16_t*)values)[i]) : ((const float*)values)[i];
        if (value < lowest && isfinite(value)) lowest = value;
    }
    return lowest;
}

/* ---- slices ---- */

/* A block of a slab: whether it has one value, the bits of its first one, and ty_value_outside. */
typedef struct block_kind {
    bool common;
    uint32_t bits;
    float lowest;
} block_kind;

/* A grid in the making: slabs of TY_GRID_BLOCK slices are surveyed, which fills the table, and then stored. */
typedef struct slicing {
    ty_context* context;
    ty_grid_def def;
    const ty_slice_source* source;
    const uint8_t* slab;
    int32_t first, slices; /* of the slab */
    block_kind* kinds;     /* of the slab's blocks */
    ty_grid_blocks blocks;
    int32_t low[3], high[3]; /* the blocks that are stored */
    bool has_common;
    uint32_t common;
    bool paged;
    uint8_t* values;
    float lowest;
} slicing;

static size_t row_bytes(const slicing* s) {
    return (size_t)s->def.size[0] * ty_grid_value_size(s->def.type);
}

/* Row (j, k) of the slab, from voxel i on. */
static const uint8_t* slab_at(const slicing* s, int32_t i, int32_t j, int32_t k) {
    const int32_t rows = s->source->rows > 0 ? s->source->rows : s->def.size[1];
    return s->slab + row_bytes(s) * ((size_t)(j - s->source->row) + (size_t)rows * (size_t)k) +
           (size_t)i * ty_grid_value_size(s->def.type);
}

static ty_result load_slab(slicing* s, int32_t first) {
    const int32_t left = s->def.size[2] - first;
    const void* values = NULL;
    s->first = first;
    s->slices = left < TY_GRID_BLOCK ? left : TY_GRID_BLOCK;
    const ty_result result = s->source->slices(s->source->user, first, s->slices, &values);
    s->slab = values;
    return result;
}

static uint32_t bits_at(const slicing* s, const uint8_t* from, int32_t i) {
    if (s->def.type == TY_GRID_F16) return ((const uint16_t*)(const void*)from)[i];
    return ((const uint32_t*)(const void*)from)[i];
}

static float value_of(const slicing* s, uint32_t bits) {
    return s->def.type == TY_GRID_F16 ? ty_half_to_float((uint16_t)bits) : ty_float_from_bits(bits);
}

static int32_t extent_of(int32_t block, int32_t size) {
    const int32_t left = size - TY_GRID_BLOCK * block;
    return left < TY_GRID_BLOCK ? left : TY_GRID_BLOCK;
}

/* Folds the bits of a row's values: those that differ from the block's first value, and those that are set in any. */
static void fold_bits(const slicing* s, const uint8_t* row, int32_t count, uint32_t first, uint32_t* differ,
                      uint32_t* any) {
    for (int32_t i = 0; i < count; ++i) {
        const uint32_t bits = bits_at(s, row, i);
        *differ |= bits ^ first;
        *any |= bits;
    }
}

static block_kind survey_block(const slicing* s, int32_t bi, int32_t bj) {
    const int32_t nx = extent_of(bi, s->def.size[0]), ny = extent_of(bj, s->def.size[1]);
    const uint32_t sign = s->def.type == TY_GRID_F16 ? 0x8000u : 0x80000000u;
    block_kind kind = {.bits = bits_at(s, slab_at(s, TY_GRID_BLOCK * bi, TY_GRID_BLOCK * bj, 0), 0)};
    uint32_t differ = 0, any = 0;
    for (int32_t k = 0; k < s->slices; ++k)
        for (int32_t j = 0; j < ny; ++j)
            fold_bits(s, slab_at(s, TY_GRID_BLOCK * bi, TY_GRID_BLOCK * bj + j, k), nx, kind.bits, &differ, &any);
    kind.common = differ == 0 && isfinite(value_of(s, kind.bits));
    for (int32_t row = 0; row < ny * s->slices && (any & sign) != 0; ++row) {
        const uint8_t* values = slab_at(s, TY_GRID_BLOCK * bi, TY_GRID_BLOCK * bj + row % ny, row / ny);
        kind.lowest = ty_minf(kind.lowest, ty_value_outside(s->def.type, values, (size_t)nx));
    }
    return kind;
}

static void survey_row(void* user, int64_t row, int32_t worker) {
    const slicing* s = user;
    const int32_t bj = s->low[1] + (int32_t)row;
    (void)worker;
    for (int32_t bi = s->low[0]; bi < s->high[0]; ++bi)
        s->kinds[(size_t)bj * (size_t)s->blocks.size[0] + (size_t)bi] = survey_block(s, bi, bj);
}

static int32_t stored_rows(const slicing* s) {
    return s->high[1] - s->low[1];
}

/* Gives the slab's blocks their numbers. The first block of one value makes that value the common one. */
static void number_blocks(slicing* s) {
    const size_t count = (size_t)s->blocks.size[0] * (size_t)s->blocks.size[1];
    uint32_t* numbers = s->blocks.table + count * (size_t)(s->first / TY_GRID_BLOCK);
    for (int32_t bj = s->low[1]; bj < s->high[1]; ++bj)
        for (int32_t bi = s->low[0]; bi < s->high[0]; ++bi) {
            const size_t i = (size_t)bj * (size_t)s->blocks.size[0] + (size_t)bi;
            const block_kind* kind = &s->kinds[i];
            if (kind->common && !s->has_common) {
                s->has_common = true;
                s->common = kind->bits;
            }
            numbers[i] = kind->common && kind->bits == s->common ? 0 : s->blocks.count++;
            if (kind->lowest < s->lowest) s->lowest = kind->lowest;
        }
}

static size_t voxel_count(const slicing* s) {
    return (size_t)s->def.size[0] * (size_t)s->def.size[1] * (size_t)s->def.size[2];
}

/* Numbers the blocks anew, one cube of TILE^3 after the other, so that those that a path visits next to one another lie
 * in pages next to one another. */
static void number_by_tiles(ty_grid_blocks* blocks) {
    enum { TILE = 4 };
    const int32_t* size = blocks->size;
    uint32_t next = 1;
    int32_t tile[3], end[3];
    for (tile[2] = 0; tile[2] < size[2]; tile[2] += TILE)
        for (tile[1] = 0; tile[1] < size[1]; tile[1] += TILE)
            for (tile[0] = 0; tile[0] < size[0]; tile[0] += TILE) {
                for (int a = 0; a < 3; ++a) end[a] = tile[a] + TILE < size[a] ? tile[a] + TILE : size[a];
                for (int32_t k = tile[2]; k < end[2]; ++k)
                    for (int32_t j = tile[1]; j < end[1]; ++j) {
                        uint32_t* row = blocks->table + (size_t)size[0] * ((size_t)j + (size_t)size[1] * (size_t)k);
                        for (int32_t i = tile[0]; i < end[0]; ++i)
                            if (row[i] != 0) row[i] = next++;
                    }
            }
}

/* Fills the table; it is freed where TY_GRID_AUTO chooses a dense grid. */
static ty_result survey(slicing* s, ty_grid_storage storage) {
    static const int32_t none[3] = {0, 0, 0};
    const size_t voxels = voxel_count(s);
    s->paged = storage == TY_GRID_PAGED;
    if (storage == TY_GRID_DENSE) return TY_OK;
    if (storage == TY_GRID_AUTO && !ty_grid_saves_memory(s->def.type, voxels, 0, 0)) return TY_OK;
    if (ty_grid_blocks_table(s->context, s->def.size, none, &s->blocks) == NULL) return TY_ERROR_MEMORY;
    const size_t table = ty_grid_table_count(&s->blocks);
    const size_t kinds = (size_t)s->blocks.size[0] * (size_t)s->blocks.size[1];
    s->kinds = ty_alloc_array(s->context, kinds, sizeof *s->kinds, false);
    ty_result result = s->kinds != NULL ? TY_OK : TY_ERROR_MEMORY;
    bool saves = true;
    for (int32_t b = s->low[2]; b < s->high[2] && result == TY_OK && saves; ++b) {
        result = load_slab(s, TY_GRID_BLOCK * b);
        if (result != TY_OK) break;
        ty_parallel_for(s->context, stored_rows(s), survey_row, s);
        number_blocks(s);
        saves = storage != TY_GRID_AUTO || ty_grid_saves_memory(s->def.type, voxels, table, s->blocks.count);
    }
    ty_free_array(s->context, s->kinds, kinds, sizeof *s->kinds);
    if (result == TY_OK && s->paged) number_by_tiles(&s->blocks);
    if (result == TY_OK && saves) return TY_OK;
    ty_free_array(s->context, s->blocks.table, table, sizeof *s->blocks.table);
    s->blocks.table = NULL;
    return result;
}

static void store_block(const slicing* s, uint32_t number, int32_t bi, int32_t bj) {
    const size_t bytes = ty_grid_value_size(s->def.type);
    uint8_t* to = s->values + (size_t)number * TY_GRID_BLOCK_VOXELS * bytes;
    const int32_t ny = extent_of(bj, s->def.size[1]);
    memset(to, 0, TY_GRID_BLOCK_VOXELS * bytes);
    for (int32_t k = 0; k < s->slices; ++k)
        for (int32_t j = 0; j < ny; ++j)
            memcpy(to + bytes * TY_GRID_BLOCK * (size_t)(j + TY_GRID_BLOCK * k),
                   slab_at(s, TY_GRID_BLOCK * bi, TY_GRID_BLOCK * bj + j, k),
                   bytes * (size_t)extent_of(bi, s->def.size[0]));
}

static void store_row(void* user, int64_t stored, int32_t worker) {
    const slicing* s = user;
    const int32_t bj = s->low[1] + (int32_t)stored;
    const size_t row = (size_t)bj + (size_t)s->blocks.size[1] * (size_t)(s->first / TY_GRID_BLOCK);
    (void)worker;
    for (int32_t bi = s->low[0]; bi < s->high[0]; ++bi) {
        const uint32_t number = s->blocks.table[row * (size_t)s->blocks.size[0] + (size_t)bi];
        if (number != 0) store_block(s, number, bi, bj);
    }
}

static void fill_common(slicing* s) {
    for (size_t i = 0; i < TY_GRID_BLOCK_VOXELS; ++i)
        if (s->def.type == TY_GRID_F16)
            ((uint16_t*)(void*)s->values)[i] = (uint16_t)s->common;
        else
            ((uint32_t*)(void*)s->values)[i] = s->common;
}

/* Copies the slices into the blocks, or into a dense array. */
static ty_result store_slices(slicing* s) {
    const bool sparse = s->blocks.table != NULL;
    if (sparse) fill_common(s);
    ty_result result = TY_OK;
    for (int32_t b = s->low[2]; b < s->high[2] && result == TY_OK; ++b) {
        result = load_slab(s, TY_GRID_BLOCK * b);
        if (result != TY_OK) break;
        const size_t slice = row_bytes(s) * (size_t)s->def.size[1];
        if (sparse)
            ty_parallel_for(s->context, stored_rows(s), store_row, s);
        else
            memcpy(s->values + slice * (size_t)s->first, s->slab, slice * (size_t)s->slices);
    }
    return result;
}

/* The grid of a source that was surveyed. */
static ty_result finish(slicing* s, bool lowest_outside, ty_grid** out) {
    const bool sparse = s->blocks.table != NULL;
    const size_t bytes = ty_grid_value_size(s->def.type);
    const size_t stored = sparse ? (size_t)s->blocks.count * TY_GRID_BLOCK_VOXELS : voxel_count(s);
    ty_result result = TY_OK;
    if (sparse)
        s->values = ty_grid_blocks_values(s->context, s->def.type, s->paged, &s->blocks, &result);
    else
        s->values = ty_alloc_array(s->context, stored, bytes, false);
    if (result == TY_OK) result = s->values != NULL ? store_slices(s) : TY_ERROR_MEMORY;
    if (result != TY_OK && sparse) ty_grid_free_blocks(s->context, s->def.type, &s->blocks, s->values);
    if (result != TY_OK && !sparse) ty_free_array(s->context, s->values, stored, bytes);
    if (result != TY_OK) return result;
    if (lowest_outside) s->def.background = sparse ? s->lowest : ty_value_outside(s->def.type, s->values, stored);
    return sparse ? ty_grid_adopt_blocks(s->context, &s->def, &s->blocks, s->values, out)
                  : ty_grid_adopt(s->context, &s->def, s->values, out);
}

static slicing begin(ty_context* context, const ty_grid_def* def, const ty_grid_plan* plan,
                     const ty_slice_source* source) {
    slicing s = {.context = context, .def = *def, .source = source};
    for (int a = 0; a < 3; ++a) ty_grid_plan_blocks(plan, a, def->size[a], 0, &s.low[a], &s.high[a]);
    return s;
}

static ty_grid_storage storage_of(const ty_grid_plan* plan) {
    return plan->part && plan->storage != TY_GRID_PAGED ? TY_GRID_SPARSE : plan->storage;
}

ty_result ty_grid_create_from_slices(ty_context* context, const ty_grid_def* def, const ty_grid_plan* plan,
                                     const ty_slice_source* source, bool lowest_outside, ty_grid** out) {
    slicing s = begin(context, def, plan, source);
    const ty_result result = survey(&s, storage_of(plan));
    return result == TY_OK ? finish(&s, lowest_outside, out) : result;
}

/* ---- other storage ---- */

static ty_grid_def describe(const ty_grid* grid) {
    ty_grid_def def = ty_default_grid_def();
    memcpy(def.size, grid->size, sizeof def.size);
    def.type = grid->type;
    def.index_to_local = grid->index_to_local;
    def.placed = grid->placed;
    def.background = grid->background;
    return def;
}

/* Slices of a dense grid, as ty_slice_source. */
static ty_result own_slices(void* user, int32_t first, int32_t count, const void** values) {
    const ty_grid* grid = user;
    const size_t slice = (size_t)grid->size[0] * (size_t)grid->size[1] * ty_grid_value_size(grid->type);
    (void)count;
    *values = (const uint8_t*)grid->values + slice * (size_t)first;
    return TY_OK;
}

typedef struct expansion {
    const ty_grid* grid;
    ty_grid_view view;
    uint8_t* values;
} expansion;

static void expand_slice(void* user, int64_t k, int32_t worker) {
    const expansion* e = user;
    const int32_t* size = e->grid->size;
    const size_t bytes = ty_grid_value_size(e->grid->type);
    uint8_t* to = e->values + bytes * (size_t)size[0] * (size_t)size[1] * (size_t)k;
    (void)worker;
    for (int32_t j = 0; j < size[1]; ++j) {
        int32_t count;
        for (int32_t i = 0; i < size[0]; i += count, to += bytes * (size_t)count) {
            size_t at;
            count = ty_grid_run(&e->view, i, j, (int32_t)k, &at);
            memcpy(to, (const uint8_t*)e->grid->values + bytes * at, bytes * (size_t)count);
        }
    }
}

static ty_result make_dense(ty_context* context, const ty_grid* grid, ty_grid** out) {
    const ty_grid_def def = describe(grid);
    expansion e = {.grid = grid,
                   .view = ty_grid_get_view(grid),
                   .values = ty_alloc_array(context, grid->voxels, ty_grid_value_size(grid->type), false)};
    if (e.values == NULL) return TY_ERROR_MEMORY;
    ty_parallel_for(context, grid->size[2], expand_slice, &e);
    return ty_grid_adopt(context, &def, e.values, out);
}

enum { BLOCKS_A_TASK = 4096 };

typedef struct block_copy {
    const uint8_t* from;
    uint8_t* to;
    size_t bytes, count; /* of a block, and blocks */
} block_copy;

static void copy_some_blocks(void* user, int64_t task, int32_t worker) {
    const block_copy* copy = user;
    const size_t first = (size_t)task * BLOCKS_A_TASK, left = copy->count - first;
    (void)worker;
    memcpy(copy->to + copy->bytes * first, copy->from + copy->bytes * first,
           copy->bytes * (left < BLOCKS_A_TASK ? left : BLOCKS_A_TASK));
}

/* The same table in memory, without values; false if memory runs out. */
static bool copy_table(ty_context* context, const ty_grid_blocks* from, ty_grid_blocks* to) {
    const size_t count = ty_grid_table_count(from);
    *to = *from;
    to->mapping = NULL;
    to->maps_tables = false;
    to->table = ty_alloc_array(context, count, sizeof *to->table, false);
    if (to->table != NULL) memcpy(to->table, from->table, count * sizeof *to->table);
    return to->table != NULL;
}

static ty_result make_sparse(ty_context* context, ty_grid* grid, const ty_grid_plan* plan, ty_grid** out) {
    const ty_slice_source source = {own_slices, grid, 0, 0};
    const ty_grid_def def = describe(grid);
    slicing s = begin(context, &def, plan, &source);
    const ty_result result = survey(&s, storage_of(plan));
    if (result != TY_OK) return result;
    if (s.blocks.table == NULL) {
        *out = ty_grid_retain(grid);
        return TY_OK;
    }
    return finish(&s, false, out);
}

/* The blocks of a grid that has some, in memory or in a file; taken in parts, as a file may be larger than memory. */
static ty_result copy_blocks(ty_context* context, const ty_grid* grid, bool paged, ty_grid** out) {
    const ty_grid_def def = describe(grid);
    const size_t bytes = TY_GRID_BLOCK_VOXELS * ty_grid_value_size(grid->type);
    ty_grid_blocks blocks;
    ty_result result;
    if (!copy_table(context, &grid->blocks, &blocks)) return TY_ERROR_MEMORY;
    uint8_t* values = ty_grid_blocks_values(context, grid->type, paged, &blocks, &result);
    if (result != TY_OK) {
        ty_grid_free_blocks(context, grid->type, &blocks, NULL);
        return result;
    }
    block_copy copy = {.from = grid->values, .to = values, .bytes = bytes, .count = blocks.count};
    ty_parallel_for(context, ((int64_t)blocks.count + BLOCKS_A_TASK - 1) / BLOCKS_A_TASK, copy_some_blocks, &copy);
    return ty_grid_adopt_blocks(context, &def, &blocks, values, out);
}

ty_result ty_grid_store(ty_context* context, ty_grid* grid, ty_grid_storage storage, ty_grid** out) {
    if (grid == NULL || out == NULL || storage < TY_GRID_AUTO || storage > TY_GRID_PAGED)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "ty_grid_store: grid or out is NULL, or the storage not a ty_grid_storage");
    const bool sparse = grid->blocks.table != NULL, paged = grid->blocks.mapping != NULL;
    if (storage == TY_GRID_DENSE && sparse) return make_dense(context, grid, out);
    const ty_grid_plan plan = {.storage = storage};
    if (storage != TY_GRID_DENSE && !sparse) return make_sparse(context, grid, &plan, out);
    if (storage == (paged ? TY_GRID_SPARSE : TY_GRID_PAGED)) return copy_blocks(context, grid, !paged, out);
    *out = ty_grid_retain(grid);
    return TY_OK;
}

/* ---- parts ---- */

/* Numbers the stored blocks of a part anew; sources[n] is the number that block n had. */
static uint32_t number_part(const ty_grid* grid, const ty_grid_plan* plan, const ty_grid_blocks* to,
                            uint32_t* sources) {
    const ty_grid_blocks* from = &grid->blocks;
    int32_t low[3], high[3];
    uint32_t count = 1;
    for (int a = 0; a < 3; ++a) ty_grid_plan_blocks(plan, a, grid->size[a], from->shift[a], &low[a], &high[a]);
    for (int32_t k = low[2]; k < high[2]; ++k)
        for (int32_t j = low[1]; j < high[1]; ++j)
            for (int32_t i = low[0]; i < high[0]; ++i) {
                const size_t at = (size_t)i + (size_t)from->size[0] * ((size_t)j + (size_t)from->size[1] * (size_t)k);
                if (from->table[at] == 0) continue;
                if (to != NULL) to->table[at] = count;
                if (sources != NULL) sources[count] = from->table[at];
                ++count;
            }
    return count;
}

/* The blocks of a part; a block that several places share becomes several. */
static ty_result keep_blocks(ty_context* context, const ty_grid* grid, const ty_grid_plan* plan, ty_grid** out) {
    const ty_grid_def def = describe(grid);
    const size_t bytes = TY_GRID_BLOCK_VOXELS * ty_grid_value_size(grid->type);
    ty_grid_blocks blocks;
    ty_result result = TY_OK;
    if (ty_grid_blocks_table(context, grid->size, grid->blocks.shift, &blocks) == NULL) return TY_ERROR_MEMORY;
    blocks.count = number_part(grid, plan, NULL, NULL);
    const uint32_t count = blocks.count;
    uint32_t* sources = ty_alloc_array(context, count, sizeof *sources, true);
    uint8_t* values = NULL;
    if (sources == NULL) result = TY_ERROR_MEMORY;
    if (result == TY_OK)
        values = ty_grid_blocks_values(context, grid->type, plan->storage == TY_GRID_PAGED, &blocks, &result);
    if (result == TY_OK) {
        number_part(grid, plan, &blocks, sources);
        for (uint32_t n = 0; n < count; ++n)
            memcpy(values + bytes * n, (const uint8_t*)grid->values + bytes * sources[n], bytes);
        result = ty_grid_adopt_blocks(context, &def, &blocks, values, out);
    } else {
        ty_grid_free_blocks(context, grid->type, &blocks, NULL);
    }
    ty_free_array(context, sources, count, sizeof *sources);
    return result;
}

ty_result ty_grid_keep_part(ty_context* context, ty_grid* grid, const ty_grid_plan* plan, ty_grid** out) {
    return grid->blocks.table != NULL ? keep_blocks(context, grid, plan, out) : make_sparse(context, grid, plan, out);
}

/* ---- halves ---- */

typedef struct halving {
    const float* from;
    uint16_t* to;
    size_t count;
} halving;

static void halve_some(void* user, int64_t task, int32_t worker) {
    const halving* h = user;
    const size_t values = (size_t)BLOCKS_A_TASK * TY_GRID_BLOCK_VOXELS, first = (size_t)task * values;
    const size_t end = h->count - first < values ? h->count : first + values;
    (void)worker;
    for (size_t i = first; i < end; ++i) h->to[i] = ty_float_to_half(h->from[i]);
}

ty_result ty_grid_make_half(ty_context* context, const ty_grid* grid, ty_grid** out) {
    const bool sparse = grid->blocks.table != NULL;
    const size_t values = (size_t)BLOCKS_A_TASK * TY_GRID_BLOCK_VOXELS;
    halving h = {.from = grid->values, .count = grid->stored};
    ty_grid_def def = describe(grid);
    ty_grid_blocks blocks = {.table = NULL};
    ty_result result = TY_OK;
    def.type = TY_GRID_F16;
    def.background = ty_half_to_float(ty_float_to_half(grid->background));
    if (sparse && !copy_table(context, &grid->blocks, &blocks)) return TY_ERROR_MEMORY;
    if (sparse)
        h.to = ty_grid_blocks_values(context, def.type, grid->blocks.mapping != NULL, &blocks, &result);
    else
        h.to = ty_alloc_array(context, grid->stored, sizeof *h.to, false);
    if (h.to == NULL) {
        if (sparse) ty_grid_free_blocks(context, def.type, &blocks, NULL);
        return result != TY_OK ? result : TY_ERROR_MEMORY;
    }
    ty_parallel_for(context, (int64_t)((grid->stored + values - 1) / values), halve_some, &h);
    return sparse ? ty_grid_adopt_blocks(context, &def, &blocks, h.to, out) : ty_grid_adopt(context, &def, h.to, out);
}
