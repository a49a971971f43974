/* Files of bricks: a grid as TY_GRID_PAGED keeps it. A head of HEAD_SPACE bytes, the extremes of the bricks, the table
 * of the blocks and the blocks, each at a multiple of HEAD_SPACE. Little-endian. */
#include "io/volumes/volume_file.h"

#include "base/context.h"
#include "base/mapping.h"
#include "grid/grid.h"
#include "io/file.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

static const char magic[8] = {'T', 'Y', 'B', 'R', 'I', 'C', 'K', 'S'};

enum { VERSION = 1, BYTE_ORDER_MARK = 0x01020304, HEAD_SPACE = 4096 };
/* Entries of a table that are checked, and bytes that are written, at once. */
enum { CHECKED_AT_ONCE = 1 << 20, WRITTEN_AT_ONCE = 1 << 22 };

typedef struct bricks_head {
    char magic[8];
    uint32_t version, byte_order;
    int32_t type, placed; /* ty_grid_type; 0 or 1 */
    int32_t size[3], table_size[3], shift[3];
    uint32_t count; /* blocks */
    float background, min, max;
    uint32_t unused; /* 0 */
    double mean;
    int64_t active;
    double index_to_local[12];
    uint64_t extremes, table, values, end; /* offsets */
    uint64_t hash;                         /* FNV-1a of extremes, table and values */
} bricks_head;

_Static_assert(sizeof(bricks_head) == 232, "the head has no gaps");

static ty_result damaged(ty_context* context, const char* path, const char* what) {
    return ty_fail(context, TY_ERROR_INPUT, "%s: damaged or cut short (%s)", path, what);
}

static uint64_t round_up(uint64_t bytes) {
    return (bytes + HEAD_SPACE - 1) / HEAD_SPACE * HEAD_SPACE;
}

static uint64_t brick_count(const bricks_head* head) {
    uint64_t count = 1;
    for (int a = 0; a < 3; ++a) count *= (uint64_t)((head->size[a] + TY_BRICK) / TY_BRICK);
    return count;
}

static uint64_t table_count(const bricks_head* head) {
    return (uint64_t)head->table_size[0] * (uint64_t)head->table_size[1] * (uint64_t)head->table_size[2];
}

static uint64_t values_bytes(const bricks_head* head) {
    return (uint64_t)head->count * TY_GRID_BLOCK_VOXELS * ty_grid_value_size((ty_grid_type)head->type);
}

/* Sets the offsets, which follow from the counts. */
static void lay_out(bricks_head* head) {
    head->extremes = HEAD_SPACE;
    head->table = round_up(head->extremes + brick_count(head) * 2 * sizeof(float));
    head->values = round_up(head->table + table_count(head) * sizeof(uint32_t));
    head->end = head->values + values_bytes(head);
}

bool ty_bricks_hash(const char* path, uint64_t* hash) {
    bricks_head head;
    if (ty_read_head(path, &head, sizeof head) != sizeof head || memcmp(head.magic, magic, sizeof magic) != 0)
        return false;
    *hash = ty_hash_bytes(*hash, &head, sizeof head);
    return true;
}

/* ---- reading ---- */

static bool has_measured_values(const bricks_head* head) {
    return isfinite(head->background) && isfinite(head->min) && isfinite(head->max) && isfinite(head->mean) &&
           head->min <= head->max && head->active >= 0;
}

static ty_result check_head(ty_context* context, const char* path, const bricks_head* head, size_t file_size) {
    const int64_t sides[3] = {head->size[0], head->size[1], head->size[2]};
    size_t voxels = 0;
    if (memcmp(head->magic, magic, sizeof magic) != 0)
        return ty_fail(context, TY_ERROR_INPUT, "%s: not a file of bricks", path);
    if (head->version != VERSION || head->byte_order != BYTE_ORDER_MARK)
        return ty_fail(context, TY_ERROR_INPUT, "%s: version %u of files of bricks; %d, little-endian, can be read",
                       path, (unsigned)head->version, (int)VERSION);
    if (head->type != TY_GRID_F32 && head->type != TY_GRID_F16) return damaged(context, path, "type");
    const ty_result result = ty_check_volume_storage(context, path, TY_GRID_PAGED, true, sides, &voxels);
    if (result != TY_OK) return result;
    for (int a = 0; a < 3; ++a)
        if (head->shift[a] < 0 || head->shift[a] >= TY_GRID_BLOCK ||
            head->table_size[a] != (head->size[a] + head->shift[a] + TY_GRID_BLOCK - 1) / TY_GRID_BLOCK)
            return damaged(context, path, "table");
    bricks_head expected = *head;
    lay_out(&expected);
    if (head->count < 1 || head->count > table_count(head) + 1 || memcmp(&expected, head, sizeof expected) != 0)
        return damaged(context, path, "offsets");
    if (head->end != file_size)
        return ty_fail(context, TY_ERROR_INPUT, "%s: %llu bytes, of which its head accounts for %llu", path,
                       (unsigned long long)file_size, (unsigned long long)head->end);
    return has_measured_values(head) ? TY_OK : damaged(context, path, "range");
}

typedef struct tables_job {
    const uint32_t* table;
    const float* extremes;
    uint64_t entries, bricks;
    uint32_t blocks;
    _Atomic bool bad;
} tables_job;

static void check_tables_part(void* user, int64_t task, int32_t worker) {
    tables_job* job = user;
    const uint64_t first = (uint64_t)task * CHECKED_AT_ONCE, last = first + CHECKED_AT_ONCE;
    bool bad = false;
    (void)worker;
    for (uint64_t i = first; i < last && i < job->entries; ++i) bad = bad || job->table[i] >= job->blocks;
    for (uint64_t i = first; i < last && i < job->bricks; ++i) {
        const float low = job->extremes[2 * i], high = job->extremes[2 * i + 1];
        bad = bad || !isfinite(low) || !isfinite(high) || low > high;
    }
    if (bad) atomic_store(&job->bad, true);
}

/* Every entry names a block that is there. */
static ty_result check_tables(ty_context* context, const char* path, const bricks_head* head, const uint8_t* bytes) {
    tables_job job = {.table = (const uint32_t*)(const void*)(bytes + head->table),
                      .extremes = (const float*)(const void*)(bytes + head->extremes),
                      .entries = table_count(head),
                      .bricks = brick_count(head),
                      .blocks = head->count};
    atomic_init(&job.bad, false);
    const uint64_t count = job.entries > job.bricks ? job.entries : job.bricks;
    ty_parallel_for(context, (int64_t)((count + CHECKED_AT_ONCE - 1) / CHECKED_AT_ONCE), check_tables_part, &job);
    return atomic_load(&job.bad) ? damaged(context, path, "table") : TY_OK;
}

static ty_grid_def describe(const bricks_head* head) {
    ty_grid_def def = ty_default_grid_def();
    memcpy(def.size, head->size, sizeof def.size);
    memcpy(def.index_to_local.m, head->index_to_local, sizeof def.index_to_local.m);
    def.type = (ty_grid_type)head->type;
    def.placed = head->placed != 0;
    def.background = head->background;
    return def;
}

static ty_result check_mapping(ty_context* context, const char* path, const ty_mapping* mapping, bricks_head* head) {
    if (mapping->size < HEAD_SPACE) return damaged(context, path, "head");
    memcpy(head, mapping->bytes, sizeof *head);
    ty_result result = check_head(context, path, head, mapping->size);
    if (result == TY_OK) result = check_tables(context, path, head, mapping->bytes);
    if (result != TY_OK) return result;
    const ty_grid_def def = describe(head);
    ty_affine inverse;
    return ty_affine_invert(&def.index_to_local, &inverse) ? TY_OK : damaged(context, path, "transform");
}

ty_result ty_bricks_read(ty_context* context, const char* path, ty_grid** out) {
    ty_mapping* mapping = NULL;
    bricks_head head;
    ty_result result = ty_mapping_open(context, path, &mapping);
    if (result != TY_OK) return result;
    result = check_mapping(context, path, mapping, &head);
    if (result != TY_OK) {
        ty_mapping_close(mapping);
        return result;
    }
    mapping->kept = head.values;
    const ty_grid_def def = describe(&head);
    ty_grid_blocks blocks = {
        .table = (uint32_t*)(void*)(mapping->bytes + head.table), .count = head.count, .mapping = mapping};
    memcpy(blocks.size, head.table_size, sizeof blocks.size);
    memcpy(blocks.shift, head.shift, sizeof blocks.shift);
    const ty_grid_measured measured = {head.min, head.max, head.mean, head.active};
    return ty_grid_adopt_mapping(context, &def, &blocks, mapping->bytes + head.values,
                                 (const float*)(const void*)(mapping->bytes + head.extremes), &measured, out);
}

/* ---- writing ---- */

static bricks_head make_head(const ty_grid* grid) {
    bricks_head head = {.version = VERSION,
                        .byte_order = BYTE_ORDER_MARK,
                        .type = (int32_t)grid->type,
                        .placed = grid->placed,
                        .count = grid->blocks.count,
                        .background = grid->background,
                        .min = grid->min,
                        .max = grid->max,
                        .mean = grid->mean,
                        .active = grid->active,
                        .hash = TY_HASH_START};
    memcpy(head.magic, magic, sizeof magic);
    memcpy(head.size, grid->size, sizeof head.size);
    memcpy(head.table_size, grid->blocks.size, sizeof head.table_size);
    memcpy(head.shift, grid->blocks.shift, sizeof head.shift);
    memcpy(head.index_to_local, grid->index_to_local.m, sizeof head.index_to_local);
    lay_out(&head);
    return head;
}

/* Writes an array at its offset, and extends the hash by it. */
static void put(const ty_grid* grid, ty_output* output, uint64_t offset, const void* from, uint64_t bytes,
                uint64_t* hash) {
    const uint8_t* at = from;
    for (uint64_t done = 0; done < bytes && output->error == 0; done += WRITTEN_AT_ONCE) {
        const uint64_t left = bytes - done;
        const size_t part = (size_t)(left < WRITTEN_AT_ONCE ? left : WRITTEN_AT_ONCE);
        if (grid->blocks.mapping != NULL && from == grid->values)
            ty_mapping_prefetch(grid->blocks.mapping, at + done, part);
        ty_output_write_at(output, at + done, part, offset + done);
        *hash = ty_hash_bytes(*hash, at + done, part);
        if (ty_mappings_are_bounded(grid->context)) ty_mappings_trim(grid->context);
    }
}

static ty_result write_blocks(ty_context* context, const ty_grid* grid, const char* path) {
    bricks_head head = make_head(grid);
    ty_output output;
    const ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    put(grid, &output, head.extremes, grid->extremes, brick_count(&head) * 2 * sizeof(float), &head.hash);
    put(grid, &output, head.table, grid->blocks.table, table_count(&head) * sizeof(uint32_t), &head.hash);
    put(grid, &output, head.values, grid->values, values_bytes(&head), &head.hash);
    ty_output_write_at(&output, &head, sizeof head, 0);
    return ty_output_commit(context, &output);
}

ty_result ty_bricks_write(ty_context* context, const ty_grid* grid, const char* path) {
    ty_grid* blocks = NULL;
    if (grid->blocks.table != NULL) return write_blocks(context, grid, path);
    ty_result result = ty_grid_store(context, (ty_grid*)grid, TY_GRID_PAGED, &blocks);
    if (result != TY_OK) return result;
    result = write_blocks(context, blocks, path);
    ty_grid_release(blocks);
    return result;
}
