/* Trees of OpenVDB files, formats 222 to 224. A tree is its topology (the root's entries, and inner nodes with their
 * masks and values down to the leaves' masks), then the leaves' values in the same order. */
#include "io/volumes/vdb.h"

#include "base/context.h"
#include "base/half.h"
#include "base/mapping.h"

#include <blosc.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum {
    VALUE_SIZE_MAX = 12, /* three floats */
    BLOSC_HEAD = 16,
    PASSED_MAX = 1 << 22, /* bytes of a mapped tree that stay in memory behind a cursor */
};

/* A tree in memory, or in a mapped file. */
typedef struct tree {
    const uint8_t* bytes;
    size_t size;
    ty_mapping* mapping; /* NULL: the bytes are those of ty_vdb_load */
    uint32_t compression;
    bool half;
    ty_vdb_value value;
    size_t value_size, stored_size; /* bytes of a single value, and of one in a node's block */
    int32_t component;
    float background;
} tree;

/* A position in a tree. The first read past the end, or of an invalid value, sets `bad`, and all later reads fail. */
typedef struct tree_cursor {
    const tree* tree;
    ty_sparse* sparse;
    size_t at, unloaded; /* of a mapped tree the bytes before `unloaded` have left memory */
    bool bad, no_memory;
    uint8_t* unpacked; /* scratch for the values of any node */
    float* values;     /* the same as floats */
} tree_cursor;

static const uint8_t* read_bytes(tree_cursor* w, size_t size) {
    if (w->bad || size > w->tree->size - w->at) {
        w->bad = true;
        return NULL;
    }
    const uint8_t* found = w->tree->bytes + w->at;
    if (w->tree->mapping != NULL && w->at - w->unloaded > PASSED_MAX) {
        const size_t offset = (size_t)(w->tree->bytes - w->tree->mapping->bytes);
        ty_mapping_unload(w->tree->mapping, offset + w->unloaded, offset + w->at);
        w->unloaded = w->at;
    }
    w->at += size;
    return found;
}

static uint32_t read_u32(tree_cursor* w) {
    uint32_t value = 0;
    const uint8_t* found = read_bytes(w, sizeof value);
    if (found != NULL) memcpy(&value, found, sizeof value);
    return value;
}

static float component_of(const tree* t, const uint8_t* value, size_t bytes) {
    if (bytes == sizeof(double)) {
        double wide;
        memcpy(&wide, value + (size_t)t->component * bytes, bytes);
        return (float)wide;
    }
    if (bytes == sizeof(uint16_t)) {
        uint16_t half;
        memcpy(&half, value + (size_t)t->component * bytes, bytes);
        return ty_half_to_float(half);
    }
    float number;
    memcpy(&number, value + (size_t)t->component * bytes, bytes);
    return number;
}

/* Stored values of a node. */
typedef struct node_values {
    const uint8_t* active; /* one bit per slot */
    const uint8_t* choice; /* one bit per slot that selects one of two inactive values; NULL: the first */
    float inactive[2];
    bool sparse; /* true if only active slots' values are stored */
    const uint8_t* stored;
    size_t stored_count, packed_size; /* packed_size 0: uncompressed */
} node_values;

/* Upper bound of a codec's output for raw bytes. */
static size_t packed_size_max(size_t raw) {
    return raw + raw / 256 + 64;
}

/* Blosc trusts its own header (flags, raw size, block size, compressed size), so these are validated here. */
static bool check_blosc(const uint8_t* packed, size_t size, size_t raw) {
    uint32_t head[4];
    if (size < BLOSC_HEAD) return false;
    memcpy(head, packed, sizeof head);
    return head[1] == raw && head[2] != 0 && head[3] == size;
}

/* Blosc does not check its allocation of three blocks, so whether there is memory is tried first. */
static bool unpack_blosc(const uint8_t* packed, void* to, size_t raw) {
    uint32_t head[4];
    memcpy(head, packed, sizeof head);
    void* volatile trial = malloc(3 * (size_t)head[2] + BLOSC_HEAD);
    if (trial == NULL) return false;
    free(trial);
    return blosc_decompress_ctx(packed, to, raw, 1) == (int)raw;
}

/* Reads the values as one block: plain, or a byte count (negative: uncompressed, positive: compressed) and the
 * bytes. */
static bool read_block(tree_cursor* w, node_values* values) {
    const tree* t = w->tree;
    const size_t raw = values->stored_count * t->stored_size;
    values->stored = t->bytes;
    if (t->half && values->stored_count == 0) return true; /* an empty block is omitted */
    int64_t stored = -(int64_t)raw;
    if ((t->compression & (TY_VDB_BLOSC | TY_VDB_ZIP)) != 0) {
        const uint8_t* count = read_bytes(w, sizeof stored);
        if (count == NULL) return false;
        memcpy(&stored, count, sizeof stored);
    }
    if (stored <= 0) {
        if (stored != -(int64_t)raw) w->bad = true;
        values->stored = read_bytes(w, raw);
        return values->stored != NULL;
    }
    if ((uint64_t)stored > packed_size_max(raw)) w->bad = true;
    values->packed_size = (size_t)stored;
    values->stored = read_bytes(w, (size_t)stored);
    if (values->stored != NULL && (t->compression & TY_VDB_BLOSC) != 0 &&
        !check_blosc(values->stored, values->packed_size, raw))
        w->bad = true;
    return !w->bad;
}

static size_t count_bits(const uint8_t* mask, size_t bytes) {
    size_t count = 0;
    for (size_t i = 0; i < bytes; i += sizeof(uint64_t)) {
        uint64_t word;
        memcpy(&word, mask + i, sizeof word);
        count += (size_t)__builtin_popcountll(word);
    }
    return count;
}

static bool bit(const uint8_t* mask, size_t index) {
    return (mask[index / 8] >> index % 8 & 1) != 0;
}

/* Reads the values of a node with `slots` slots: the encoding of inactive values (0..6), up to two such values, a
 * selection mask, then the block. */
static bool read_values(tree_cursor* w, size_t slots, const uint8_t* active, node_values* values) {
    const tree* t = w->tree;
    *values = (node_values){.active = active};
    const uint8_t* coding = read_bytes(w, 1);
    if (coding == NULL || *coding > 6) {
        w->bad = true;
        return false;
    }
    values->inactive[1] = t->background;
    values->inactive[0] = *coding == 0 ? t->background : -t->background;
    const int given = *coding == 5 ? 2 : *coding == 2 || *coding == 4 ? 1 : 0;
    for (int i = 0; i < given; ++i) {
        const uint8_t* value = read_bytes(w, t->value_size);
        if (value == NULL) return false;
        values->inactive[i] = component_of(t, value, t->value.bytes);
    }
    if (*coding >= 3 && *coding <= 5) values->choice = read_bytes(w, slots / 8);
    values->sparse = (t->compression & TY_VDB_ACTIVE_MASK) != 0 && *coding != 6;
    values->stored_count = values->sparse ? count_bits(active, slots / 8) : slots;
    return read_block(w, values);
}

static bool unpack(const tree* t, const node_values* values, uint8_t* to, const uint8_t** plain) {
    const size_t raw = values->stored_count * t->stored_size;
    *plain = values->packed_size == 0 ? values->stored : to;
    if (values->packed_size == 0) return true;
    if ((t->compression & TY_VDB_BLOSC) != 0) return unpack_blosc(values->stored, to, raw);
    uLongf length = raw;
    return uncompress(to, &length, values->stored, values->packed_size) == Z_OK && length == raw;
}

static void expand(const tree* t, const node_values* values, const uint8_t* plain, size_t slots, float* to) {
    const size_t bytes = t->half ? sizeof(uint16_t) : t->value.bytes;
    if (!values->sparse && t->stored_size == sizeof(float)) {
        memcpy(to, plain, slots * sizeof *to);
        return;
    }
    size_t next = 0;
    for (size_t i = 0; i < slots; ++i) {
        if (!values->sparse || bit(values->active, i))
            to[i] = component_of(t, plain + t->stored_size * next++, bytes);
        else
            to[i] = values->inactive[values->choice != NULL && bit(values->choice, i)];
    }
}

/* The same for grids that stay half. */
static void expand_halves(const tree* t, const node_values* values, const uint8_t* plain, size_t slots, uint16_t* to) {
    const uint16_t inactive[2] = {ty_float_to_half(values->inactive[0]), ty_float_to_half(values->inactive[1])};
    const uint8_t* from = plain + sizeof(uint16_t) * (size_t)t->component;
    for (size_t i = 0; i < slots; ++i) {
        if (values->sparse && !bit(values->active, i)) {
            to[i] = inactive[values->choice != NULL && bit(values->choice, i)];
        } else {
            memcpy(&to[i], from, sizeof to[i]);
            from += t->stored_size;
        }
    }
}

static bool check_added(tree_cursor* w, bool added) {
    if (!added) w->no_memory = w->bad = true;
    return added;
}

static void offset_origin(const int32_t origin[3], size_t slot, unsigned log2, int32_t side, int32_t to[3]) {
    const size_t last = ((size_t)1 << log2) - 1;
    const size_t index[3] = {slot >> 2 * log2, slot >> log2 & last, slot & last};
    for (int a = 0; a < 3; ++a) to[a] = origin[a] + (int32_t)index[a] * side;
}

static bool read_leaf(tree_cursor* w, const int32_t origin[3]) {
    const uint8_t* mask = read_bytes(w, TY_LEAF_VOXELS / 8);
    return mask != NULL && check_added(w, ty_sparse_add_leaf(w->sparse, origin, mask, w->sparse->leaves));
}

/* Reads an inner node with 2^(3 log2) slots of size `side`: child and value masks, values, then the children in
 * order. */
static bool read_node(tree_cursor* w, const int32_t origin[3], unsigned log2, int32_t side) {
    const size_t slots = (size_t)1 << 3 * log2;
    const uint8_t* children = read_bytes(w, slots / 8);
    const uint8_t* active = read_bytes(w, slots / 8);
    node_values values;
    const uint8_t* plain;
    if (active == NULL || !read_values(w, slots, active, &values)) return false;
    if (!unpack(w->tree, &values, w->unpacked, &plain)) {
        w->bad = true;
        return false;
    }
    expand(w->tree, &values, plain, slots, w->values);
    int32_t at[3];
    for (size_t i = 0; i < slots; ++i) {
        if (bit(children, i)) continue;
        offset_origin(origin, i, log2, side, at);
        if (!check_added(w, ty_sparse_add_tile(w->sparse, at, side, bit(active, i), w->values[i]))) return false;
    }
    for (size_t i = 0; i < slots; ++i) {
        if (!bit(children, i)) continue;
        offset_origin(origin, i, log2, side, at);
        if (!(side == TY_LEAF_SIDE ? read_leaf(w, at) : read_node(w, at, log2 - 1, TY_LEAF_SIDE))) return false;
    }
    return true;
}

static bool read_origin(tree_cursor* w, int32_t origin[3]) {
    const uint8_t* found = read_bytes(w, 3 * sizeof(int32_t));
    if (found == NULL) return false;
    memcpy(origin, found, 3 * sizeof(int32_t));
    for (int a = 0; a < 3; ++a)
        if (origin[a] % TY_UPPER_SIDE != 0) w->bad = true;
    return !w->bad && check_added(w, ty_sparse_add_root(w->sparse, origin));
}

static bool read_root(tree_cursor* w, tree* t) {
    enum { UPPER_LOG2 = 5 };
    if (read_u32(w) != 1) w->bad = true; /* number of buffers */
    const uint8_t* background = read_bytes(w, t->value_size);
    if (background == NULL) return false;
    t->background = w->sparse->background = component_of(t, background, t->value.bytes);
    const uint32_t tiles = read_u32(w), children = read_u32(w);
    int32_t origin[3];
    for (uint32_t i = 0; i < tiles; ++i) {
        const uint8_t* tile = read_origin(w, origin) ? read_bytes(w, t->value_size + 1) : NULL;
        if (tile == NULL) return false;
        const uint8_t active = tile[t->value_size];
        if (active > 1) w->bad = true;
        const float value = component_of(t, tile, t->value.bytes);
        if (!check_added(w, ty_sparse_add_tile(w->sparse, origin, TY_UPPER_SIDE, active != 0, value))) return false;
    }
    for (uint32_t i = 0; i < children; ++i)
        if (!read_origin(w, origin) || !read_node(w, origin, UPPER_LOG2, TY_LOWER_SIDE)) return false;
    return !w->bad;
}

/* Finds the offset of the values of each leaf that was kept; leaves are in file order, and numbered so before. */
static void locate_leaves(tree_cursor* w) {
    ty_sparse_cell *cell = w->sparse->cells, *end = cell + w->sparse->count;
    for (uint64_t n = 0; n < w->sparse->leaves && !w->bad; ++n) {
        while (cell < end && cell->leaf == TY_SPARSE_TILE) ++cell;
        if (cell == end) return;
        if (cell->leaf == n) (cell++)->leaf = w->at;
        const uint8_t* mask = read_bytes(w, TY_LEAF_VOXELS / 8);
        node_values values;
        if (mask != NULL) read_values(w, TY_LEAF_VOXELS, mask, &values);
    }
}

static bool decode_leaf(const void* user, uint64_t leaf, void* to) {
    const tree* t = user;
    tree_cursor w = {.tree = t, .at = (size_t)leaf, .unloaded = (size_t)leaf};
    uint8_t unpacked[TY_LEAF_VOXELS * VALUE_SIZE_MAX];
    const uint8_t* plain;
    node_values values;
    const uint8_t* mask = read_bytes(&w, TY_LEAF_VOXELS / 8);
    if (mask == NULL || !read_values(&w, TY_LEAF_VOXELS, mask, &values) || !unpack(t, &values, unpacked, &plain))
        return false;
    if (t->half && t->value.bytes == sizeof(float))
        expand_halves(t, &values, plain, TY_LEAF_VOXELS, to);
    else
        expand(t, &values, plain, TY_LEAF_VOXELS, to);
    return true;
}

ty_vdb_value ty_vdb_value_of(const ty_vdb_grid* grid) {
    if (strcmp(grid->type, "Tree_float_5_4_3") == 0) return (ty_vdb_value){sizeof(float), 1};
    if (strcmp(grid->type, "Tree_double_5_4_3") == 0) return (ty_vdb_value){sizeof(double), 1};
    if (strcmp(grid->type, "Tree_vec3s_5_4_3") == 0) return (ty_vdb_value){sizeof(float), 3};
    return (ty_vdb_value){0, 0};
}

static tree describe(const ty_vdb_grid* owner, int32_t component) {
    const ty_vdb_value value = ty_vdb_value_of(owner);
    const size_t components = (size_t)value.components;
    return (tree){.compression = owner->compression,
                  .half = owner->half,
                  .value = value,
                  .value_size = components * value.bytes,
                  .stored_size = components * (owner->half ? sizeof(uint16_t) : value.bytes),
                  .component = component};
}

/* Reads a tree in memory: the topology and, if wanted, the offsets of the leaves' values. */
static ty_result read_topology(const ty_vdb_file* file, const ty_vdb_grid* owner, tree* t, bool leaves,
                               ty_sparse* sparse) {
    tree_cursor w = {.tree = t,
                     .sparse = sparse,
                     .unpacked = ty_alloc_array(file->context, TY_VDB_NODE_SLOTS_MAX, VALUE_SIZE_MAX, false),
                     .values = ty_alloc_array(file->context, TY_VDB_NODE_SLOTS_MAX, sizeof(float), false)};
    const bool allocated = w.unpacked != NULL && w.values != NULL;
    if (allocated && read_root(&w, t) && leaves) locate_leaves(&w);
    ty_free_array(file->context, w.unpacked, TY_VDB_NODE_SLOTS_MAX, VALUE_SIZE_MAX);
    ty_free_array(file->context, w.values, TY_VDB_NODE_SLOTS_MAX, sizeof(float));
    if (!allocated || w.no_memory) return TY_ERROR_MEMORY;
    return w.bad ? ty_vdb_damaged(file, owner->name) : TY_OK;
}

/* A tree is loaded, or mapped where a part of it is read. */
static ty_result open_tree(const ty_vdb_file* file, const ty_vdb_grid* owner, bool mapped, tree* t) {
    uint8_t* bytes = NULL;
    if (!mapped) {
        const ty_result result = ty_vdb_load(file, owner, &bytes, &t->size);
        t->bytes = bytes;
        return result;
    }
    const ty_result result = ty_mapping_open(file->context, file->path, &t->mapping);
    if (result != TY_OK) return result;
    t->bytes = t->mapping->bytes + owner->tree;
    t->size = (size_t)(owner->end - owner->tree);
    if (t->mapping->size >= owner->end) return TY_OK;
    ty_mapping_close(t->mapping);
    return ty_vdb_damaged(file, owner->name);
}

static void close_tree(const ty_vdb_file* file, tree* t) {
    if (t->mapping != NULL)
        ty_mapping_close(t->mapping);
    else
        ty_free_array(file->context, (uint8_t*)t->bytes, t->size, 1);
}

ty_result ty_vdb_measure(const ty_vdb_file* file, const ty_vdb_grid* owner, ty_vdb_grid* grid) {
    tree t = describe(owner, 0);
    ty_result result = open_tree(file, owner, false, &t);
    if (result != TY_OK) return result;
    ty_sparse sparse = ty_sparse_begin(file->context, file->path, owner->name);
    sparse.measures = true;
    result = read_topology(file, owner, &t, false, &sparse);
    grid->active_voxels = sparse.active;
    memcpy(grid->lower, sparse.lower, sizeof grid->lower);
    memcpy(grid->upper, sparse.upper, sizeof grid->upper);
    ty_sparse_end(&sparse);
    close_tree(file, &t);
    return result;
}

ty_result ty_vdb_read_tree(const ty_vdb_file* file, const ty_vdb_grid* owner, int32_t component,
                           const ty_affine* index_to_world, const ty_grid_plan* plan, ty_grid** out) {
    tree t = describe(owner, component);
    ty_result result = open_tree(file, owner, plan->part, &t);
    if (result != TY_OK) return result;
    ty_sparse sparse = ty_sparse_begin(file->context, file->path, owner->name);
    sparse.type = t.half && t.value.bytes == sizeof(float) ? TY_GRID_F16 : TY_GRID_F32;
    sparse.plan = *plan;
    sparse.measures = plan->part;
    if (plan->part) {
        result = read_topology(file, owner, &t, false, &sparse);
        ty_sparse_restart(&sparse);
    }
    if (result == TY_OK) result = read_topology(file, owner, &t, true, &sparse);
    if (result == TY_OK) result = ty_sparse_make_grid(&sparse, decode_leaf, &t, index_to_world, out);
    ty_sparse_end(&sparse);
    close_tree(file, &t);
    return result;
}
