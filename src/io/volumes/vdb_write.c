/* Writing OpenVDB files, format 224: grids of floats, of halves or of three of them, voxels that equal the background
 * inactive, leaves of one value as tiles. The same grids give the same bytes. */
#include "io/volumes/vdb.h"

#include "base/context.h"
#include "base/half.h"
#include "grid/grid.h"
#include "io/file.h"

#include <blosc.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum {
    VERSION = 224,
    LIBRARY_MAJOR = 10, /* release of OpenVDB that the files name; readers go by the format alone */
    LIBRARY_MINOR = 0,
    LOWER_LOG2 = 4,
    UPPER_LOG2 = 5,
    LOWER_BLOCKS = TY_LOWER_SIDE / TY_LEAF_SIDE, /* leaves along a lower node's side */
    UPPER_BLOCKS = TY_UPPER_SIDE / TY_LEAF_SIDE,
    ALL_INACTIVE_ARE_BACKGROUND = 0, /* coding of a node's inactive values */
    BLOSC_SIZE_MIN = 48,             /* smaller blocks stay uncompressed, as in OpenVDB */
    BLOSC_LEVEL = 9,
    COMPONENTS_MAX = 3,
    RAW_MAX = TY_VDB_NODE_SLOTS_MAX * COMPONENTS_MAX * (int)sizeof(float),
    PACKED_MAX = RAW_MAX + RAW_MAX / 256 + 64
};

/* Content of a node's slot: background, one value, or a child. */
typedef enum slot_kind { SLOT_EMPTY, SLOT_TILE, SLOT_CHILD } slot_kind;

typedef struct slot {
    slot_kind kind;
    float value[COMPONENTS_MAX]; /* of a tile */
} slot;

typedef struct writer {
    ty_output* output; /* whose commit reports write errors */
    const ty_volume_field* field;
    ty_grid_info info; /* of the first component */
    size_t components;
    float background[COMPONENTS_MAX];
    uint32_t compression;
    bool half;
    bool failed;       /* memory was short for a compressor */
    int32_t blocks[3]; /* leaves along each side of the grid */
    slot* slots;       /* of every leaf, x slowest */
    int64_t active;    /* active voxels */
    int32_t lower[3], upper[3];
    float values[TY_VDB_NODE_SLOTS_MAX * COMPONENTS_MAX]; /* scratch for the active values of a node */
    uint8_t raw[RAW_MAX], packed[PACKED_MAX];
} writer;

static void put(writer* w, const void* bytes, size_t size) {
    ty_output_write(w->output, bytes, size);
}

static void put_u8(writer* w, uint8_t value) {
    put(w, &value, sizeof value);
}

static void put_u32(writer* w, uint32_t value) {
    put(w, &value, sizeof value);
}

static void put_i64(writer* w, int64_t value) {
    put(w, &value, sizeof value);
}

static void put_text(writer* w, const char* text) {
    const size_t length = strlen(text);
    put_u32(w, (uint32_t)length);
    put(w, text, length);
}

static void put_metadata(writer* w, const char* key, const char* type, const void* bytes, size_t size) {
    put_text(w, key);
    put_text(w, type);
    put_u32(w, (uint32_t)size);
    put(w, bytes, size);
}

/* ---- the grid as leaves and tiles ---- */

static size_t block_index(const writer* w, const int32_t block[3]) {
    return ((size_t)block[0] * (size_t)w->blocks[1] + (size_t)block[1]) * (size_t)w->blocks[2] + (size_t)block[2];
}

static void include_voxel(writer* w, const int32_t at[3]) {
    for (int a = 0; a < 3; ++a) {
        if (w->active == 0 || at[a] < w->lower[a]) w->lower[a] = at[a];
        if (w->active == 0 || at[a] > w->upper[a]) w->upper[a] = at[a];
    }
    ++w->active;
}

/* Stores the value of a voxel; false if it is the background. */
static bool get_value(const writer* w, const int32_t at[3], float* value) {
    bool active = false;
    for (size_t c = 0; c < w->components; ++c) {
        value[c] = ty_grid_voxel(w->field->grids[c], at[0], at[1], at[2]);
        active |= value[c] != w->background[c];
    }
    return active;
}

/* True if a leaf is in the background of sparse grids. */
static bool is_background(const writer* w, const int32_t block[3]) {
    int32_t first[3], last[3];
    bool background = true;
    for (int a = 0; a < 3; ++a) {
        first[a] = TY_LEAF_SIDE * block[a];
        last[a] = first[a] + TY_LEAF_SIDE - 1;
    }
    for (size_t c = 0; c < w->components && background; ++c) {
        float value = 0;
        background = ty_grid_is_common(w->field->grids[c], first, last, &value) && value == w->background[c];
    }
    return background;
}

/* Sets the mask of a leaf's active voxels, z fastest, and appends their values; returns their number. */
static size_t gather_leaf(const writer* w, const int32_t block[3], uint8_t mask[TY_LEAF_VOXELS / 8], float* values) {
    const int32_t* size = w->info.size;
    size_t count = 0;
    memset(mask, 0, TY_LEAF_VOXELS / 8);
    if (is_background(w, block)) return 0;
    for (int32_t i = 0; i < TY_LEAF_VOXELS; ++i) {
        const int32_t at[3] = {TY_LEAF_SIDE * block[0] + (i >> 6), TY_LEAF_SIDE * block[1] + (i >> 3 & 7),
                               TY_LEAF_SIDE * block[2] + (i & 7)};
        if (at[0] >= size[0] || at[1] >= size[1] || at[2] >= size[2]) continue;
        if (!get_value(w, at, values + w->components * count)) continue;
        mask[i / 8] |= (uint8_t)(1 << i % 8);
        ++count;
    }
    return count;
}

static bool same_value(const writer* w, const float* a, const float* b) {
    for (size_t c = 0; c < w->components; ++c)
        if (a[c] != b[c]) return false;
    return true;
}

static bool all_equal(const writer* w, const float* values, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (!same_value(w, values, values + w->components * i)) return false;
    return true;
}

/* Finds every leaf's kind, and the statistics of active voxels. */
static void classify_leaves(writer* w) {
    int32_t block[3];
    for (block[0] = 0; block[0] < w->blocks[0]; ++block[0])
        for (block[1] = 0; block[1] < w->blocks[1]; ++block[1])
            for (block[2] = 0; block[2] < w->blocks[2]; ++block[2]) {
                uint8_t mask[TY_LEAF_VOXELS / 8];
                const size_t count = gather_leaf(w, block, mask, w->values);
                slot* found = &w->slots[block_index(w, block)];
                found->kind = count == 0 ? SLOT_EMPTY : SLOT_CHILD;
                memcpy(found->value, w->values, w->components * sizeof *w->values);
                if (count == TY_LEAF_VOXELS && all_equal(w, w->values, count)) found->kind = SLOT_TILE;
                for (int32_t i = 0; i < TY_LEAF_VOXELS; ++i) {
                    const int32_t at[3] = {TY_LEAF_SIDE * block[0] + (i >> 6), TY_LEAF_SIDE * block[1] + (i >> 3 & 7),
                                           TY_LEAF_SIDE * block[2] + (i & 7)};
                    if ((mask[i / 8] >> i % 8 & 1) != 0) include_voxel(w, at);
                }
            }
}

static slot leaf_slot(const writer* w, const int32_t block[3]) {
    for (int a = 0; a < 3; ++a)
        if (block[a] >= w->blocks[a]) return (slot){.kind = SLOT_EMPTY};
    return w->slots[block_index(w, block)];
}

/* Leaf number i of the node at block, whose side is 2^log2 children of `side` leaves each. */
static void child_block(const int32_t block[3], size_t i, unsigned log2, int32_t side, int32_t child[3]) {
    const size_t last = ((size_t)1 << log2) - 1;
    const size_t index[3] = {i >> 2 * log2, i >> log2 & last, i & last};
    for (int a = 0; a < 3; ++a) child[a] = block[a] + (int32_t)index[a] * side;
}

/* A node of one value throughout is a tile. */
static slot node_slot(const writer* w, const int32_t block[3], unsigned log2, int32_t side) {
    for (int a = 0; a < 3; ++a)
        if (block[a] >= w->blocks[a]) return (slot){.kind = SLOT_EMPTY};
    slot first = {.kind = SLOT_EMPTY};
    for (size_t i = 0; i < (size_t)1 << 3 * log2; ++i) {
        int32_t child[3];
        child_block(block, i, log2, side, child);
        const slot found = side == 1 ? leaf_slot(w, child) : node_slot(w, child, LOWER_LOG2, 1);
        if (i == 0) first = found;
        if (found.kind == SLOT_CHILD || found.kind != first.kind ||
            (found.kind == SLOT_TILE && !same_value(w, found.value, first.value)))
            return (slot){.kind = SLOT_CHILD};
    }
    return first;
}

/* ---- the tree ---- */

/* Compresses w->raw to w->packed; 0 if the result is not smaller. */
static size_t pack(writer* w, size_t raw) {
    if ((w->compression & TY_VDB_ZIP) != 0) {
        uLongf length = PACKED_MAX;
        const int code = compress2(w->packed, &length, w->raw, raw, Z_DEFAULT_COMPRESSION);
        w->failed |= code == Z_MEM_ERROR;
        return code == Z_OK && length < raw ? length : 0;
    }
    if (raw < BLOSC_SIZE_MIN) return 0;
    /* Blosc does not check its allocation of two blocks, so whether there is memory is tried first. */
    void* volatile trial = malloc(3 * raw + BLOSC_SIZE_MIN);
    if (trial == NULL) {
        w->failed = true;
        return 0;
    }
    free(trial);
    const size_t value_size = w->components * (w->half ? sizeof(uint16_t) : sizeof(float));
    const int length = blosc_compress_ctx(BLOSC_LEVEL, BLOSC_SHUFFLE, value_size, raw, w->raw, w->packed, PACKED_MAX,
                                          BLOSC_LZ4_COMPNAME, 0, 1);
    w->failed |= length < 0;
    return length > 0 && (size_t)length < raw ? (size_t)length : 0;
}

/* The coding of inactive values, then the active ones: plain, or a byte count (negative: uncompressed) and the bytes.
 */
static void put_values(writer* w, const float* values, size_t count) {
    put_u8(w, ALL_INACTIVE_ARE_BACKGROUND);
    if (w->half && count == 0) return;
    size_t raw = count * w->components * sizeof *values, packed = 0;
    if (w->half) {
        raw = count * w->components * sizeof(uint16_t);
        for (size_t i = 0; i < count * w->components; ++i) {
            const uint16_t half = ty_float_to_half(values[i]);
            memcpy(w->raw + i * sizeof half, &half, sizeof half);
        }
    } else {
        memcpy(w->raw, values, raw);
    }
    if ((w->compression & (TY_VDB_ZIP | TY_VDB_BLOSC)) != 0) {
        packed = pack(w, raw);
        put_i64(w, packed > 0 ? (int64_t)packed : -(int64_t)raw);
    }
    if (packed > 0)
        put(w, w->packed, packed);
    else
        put(w, w->raw, raw);
}

/* The masks and tiles of a node, then of its children down to the leaves' masks. */
static void put_node(writer* w, const int32_t block[3], unsigned log2, int32_t side) {
    const size_t slots = (size_t)1 << 3 * log2;
    uint8_t children[TY_VDB_NODE_SLOTS_MAX / 8] = {0}, active[TY_VDB_NODE_SLOTS_MAX / 8] = {0};
    size_t count = 0;
    int32_t child[3];
    for (size_t i = 0; i < slots; ++i) {
        child_block(block, i, log2, side, child);
        const slot found = side == 1 ? leaf_slot(w, child) : node_slot(w, child, LOWER_LOG2, 1);
        if (found.kind == SLOT_CHILD) children[i / 8] |= (uint8_t)(1 << i % 8);
        if (found.kind != SLOT_TILE) continue;
        active[i / 8] |= (uint8_t)(1 << i % 8);
        memcpy(w->values + w->components * count++, found.value, w->components * sizeof *w->values);
    }
    put(w, children, slots / 8);
    put(w, active, slots / 8);
    put_values(w, w->values, count);
    for (size_t i = 0; i < slots; ++i) {
        if ((children[i / 8] >> i % 8 & 1) == 0) continue;
        child_block(block, i, log2, side, child);
        if (side == 1) {
            uint8_t mask[TY_LEAF_VOXELS / 8];
            gather_leaf(w, child, mask, w->values);
            put(w, mask, sizeof mask);
        } else {
            put_node(w, child, LOWER_LOG2, 1);
        }
    }
}

/* The leaves' values, in the order of put_node. */
static void put_leaves(writer* w, const int32_t block[3], unsigned log2, int32_t side) {
    for (size_t i = 0; i < (size_t)1 << 3 * log2; ++i) {
        int32_t child[3];
        child_block(block, i, log2, side, child);
        if (side > 1) {
            if (node_slot(w, child, LOWER_LOG2, 1).kind == SLOT_CHILD) put_leaves(w, child, LOWER_LOG2, 1);
        } else if (leaf_slot(w, child).kind == SLOT_CHILD) {
            uint8_t mask[TY_LEAF_VOXELS / 8];
            const size_t count = gather_leaf(w, child, mask, w->values);
            put(w, mask, sizeof mask);
            put_values(w, w->values, count);
        }
    }
}

/* Calls for every upper node that has voxels; returns their number. */
static uint32_t for_upper_nodes(writer* w, void (*body)(writer* w, const int32_t block[3])) {
    uint32_t count = 0;
    int32_t block[3];
    for (block[0] = 0; block[0] < w->blocks[0]; block[0] += UPPER_BLOCKS)
        for (block[1] = 0; block[1] < w->blocks[1]; block[1] += UPPER_BLOCKS)
            for (block[2] = 0; block[2] < w->blocks[2]; block[2] += UPPER_BLOCKS) {
                if (node_slot(w, block, UPPER_LOG2, LOWER_BLOCKS).kind == SLOT_EMPTY) continue;
                ++count;
                if (body != NULL) body(w, block);
            }
    return count;
}

static void put_upper_node(writer* w, const int32_t block[3]) {
    for (int a = 0; a < 3; ++a) put_u32(w, (uint32_t)(TY_LEAF_SIDE * block[a]));
    put_node(w, block, UPPER_LOG2, LOWER_BLOCKS);
}

static void put_upper_leaves(writer* w, const int32_t block[3]) {
    put_leaves(w, block, UPPER_LOG2, LOWER_BLOCKS);
}

static void put_topology(writer* w) {
    put_u32(w, 1); /* buffers */
    put(w, w->background, w->components * sizeof *w->background);
    put_u32(w, 0); /* tiles of the root */
    put_u32(w, for_upper_nodes(w, NULL));
    for_upper_nodes(w, put_upper_node);
}

/* ---- the container ---- */

/* Extends a hash by the blocks of a sparse grid. */
static uint64_t hash_blocks(uint64_t hash, const ty_grid* grid) {
    const ty_grid_blocks* blocks = &grid->blocks;
    hash = ty_hash_bytes(hash, blocks->shift, sizeof blocks->shift);
    hash = ty_hash_bytes(hash, blocks->table, ty_grid_table_count(blocks) * sizeof *blocks->table);
    return ty_hash_bytes(hash, grid->values, grid->stored * ty_grid_value_size(grid->type));
}

/* Extends a hash by a field. */
static uint64_t hash_field(uint64_t hash, const ty_volume_field* field, uint32_t compression) {
    const ty_grid_info info = ty_grid_get_info(field->grids[0]);
    hash = ty_hash_bytes(hash, field->name, strlen(field->name));
    hash = ty_hash_bytes(hash, &compression, sizeof compression);
    hash = ty_hash_bytes(hash, info.index_to_local.m, sizeof info.index_to_local.m);
    if (info.storage == TY_GRID_SPARSE) {
        for (int32_t c = 0; c < field->components; ++c) hash = hash_blocks(hash, field->grids[c]);
        return hash;
    }
    for (int32_t z = 0; z < info.size[2]; ++z)
        for (int32_t y = 0; y < info.size[1]; ++y)
            for (int32_t x = 0; x < info.size[0]; ++x)
                for (int32_t c = 0; c < field->components; ++c) {
                    const float value = ty_grid_voxel(field->grids[c], x, y, z);
                    hash = ty_hash_bytes(hash, &value, sizeof value);
                }
    return hash;
}

/* The identity of the content, in the form of a UUID of version 8. */
static void put_uuid(writer* w, const ty_volume_field* fields, int32_t count) {
    uint64_t hash[2] = {TY_HASH_START, 0};
    for (int32_t i = 0; i < count; ++i) hash[0] = hash_field(hash[0], &fields[i], w->compression);
    const ty_grid_info info = ty_grid_get_info(fields[0].grids[0]);
    hash[1] = ty_hash_bytes(hash[0], info.size, sizeof info.size);
    char text[48];
    snprintf(text, sizeof text, "%08" PRIx64 "-%04" PRIx64 "-8%03" PRIx64 "-8%03" PRIx64 "-%012" PRIx64, hash[0] >> 32,
             hash[0] >> 16 & 0xffff, hash[0] & 0xfff, hash[1] >> 48 & 0xfff, hash[1] & 0xffffffffffff);
    put(w, text, TY_VDB_UUID_SIZE);
}

static void put_header(writer* w, const ty_volume_field* fields, int32_t count) {
    static const char creator[] = "Tyndall " TY_VERSION;
    put_i64(w, TY_VDB_MAGIC);
    put_u32(w, VERSION);
    put_u32(w, LIBRARY_MAJOR);
    put_u32(w, LIBRARY_MINOR);
    put_u8(w, 1); /* grids have offsets */
    put_uuid(w, fields, count);
    put_u32(w, 1);
    put_metadata(w, "creator", "string", creator, sizeof creator - 1);
    put_u32(w, (uint32_t)count);
}

static void put_grid_metadata(writer* w, const char* name) {
    const uint8_t half = w->half;
    put_u32(w, 5);
    put_metadata(w, "file_bbox_max", "vec3i", w->upper, sizeof w->upper);
    put_metadata(w, "file_bbox_min", "vec3i", w->lower, sizeof w->lower);
    put_metadata(w, "file_voxel_count", "int64", &w->active, sizeof w->active);
    put_metadata(w, "is_saved_as_half_float", "bool", &half, sizeof half);
    put_metadata(w, "name", "string", name, strlen(name));
}

/* The matrix acts on row vectors. */
static void put_transform(writer* w) {
    const double* m = w->info.index_to_local.m;
    put_text(w, "AffineMap");
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) {
            const double value = c < 3 ? m[4 * c + r] : r == 3 ? 1 : 0;
            put(w, &value, sizeof value);
        }
}

static const char* tree_type(const writer* w) {
    if (w->components == 1) return w->half ? "Tree_float_5_4_3_HalfFloat" : "Tree_float_5_4_3";
    return w->half ? "Tree_vec3s_5_4_3_HalfFloat" : "Tree_vec3s_5_4_3";
}

/* Offsets are known at the end, and are written over zeros. */
static void put_grid(writer* w) {
    const char* name = w->field->name;
    put_text(w, name);
    put_text(w, tree_type(w));
    put_text(w, ""); /* the grid whose tree this one shares */
    const uint64_t table = ty_output_position(w->output);
    uint64_t offsets[3] = {0};
    put(w, offsets, sizeof offsets);
    offsets[0] = ty_output_position(w->output);
    put_u32(w, w->compression);
    put_grid_metadata(w, name);
    put_transform(w);
    put_topology(w);
    offsets[1] = ty_output_position(w->output);
    for_upper_nodes(w, put_upper_leaves);
    offsets[2] = ty_output_position(w->output);
    ty_output_write_at(w->output, offsets, sizeof offsets, table);
    ty_output_write_at(w->output, "", 0, offsets[2]); /* the next grid goes behind */
}

static ty_result write_field(ty_context* context, writer* w, const ty_volume_field* field) {
    w->field = field;
    w->info = ty_grid_get_info(field->grids[0]);
    w->half = w->info.type == TY_GRID_F16;
    w->components = (size_t)field->components;
    w->active = 0;
    for (int a = 0; a < 3; ++a) {
        w->blocks[a] = (w->info.size[a] + TY_LEAF_SIDE - 1) / TY_LEAF_SIDE;
        w->lower[a] = 0;
        w->upper[a] = -1;
    }
    for (size_t c = 0; c < w->components; ++c) w->background[c] = ty_grid_get_info(field->grids[c]).background;
    const size_t count = (size_t)w->blocks[0] * (size_t)w->blocks[1] * (size_t)w->blocks[2];
    w->slots = ty_alloc_array(context, count, sizeof *w->slots, false);
    if (w->slots == NULL) return TY_ERROR_MEMORY;
    classify_leaves(w);
    put_grid(w);
    ty_free_array(context, w->slots, count, sizeof *w->slots);
    if (!w->failed) return TY_OK;
    return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory to compress", w->output->path);
}

ty_result ty_vdb_write_file(ty_context* context, const ty_volume_field* fields, int32_t count, uint32_t codec,
                            ty_output* output) {
    writer* w = ty_alloc_array(context, 1, sizeof *w, true);
    if (w == NULL) return TY_ERROR_MEMORY;
    w->output = output;
    w->compression = TY_VDB_ACTIVE_MASK | codec;
    put_header(w, fields, count);
    ty_result result = TY_OK;
    for (int32_t i = 0; i < count && result == TY_OK; ++i) result = write_field(context, w, &fields[i]);
    ty_free_array(context, w, 1, sizeof *w);
    return result;
}
