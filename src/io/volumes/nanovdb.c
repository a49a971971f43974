/* NanoVDB grids. The portable header does not validate its input, so it reads through functions that check every
 * access; a node is entered only if it lies within the grid, and the total size of entered nodes is limited to the
 * grid's. */
#include "io/volumes/nanovdb.h"

#include "base/context.h"
#include "base/half.h"
#include "base/mapping.h"
#include "io/file.h"
#include "io/volumes/sparse.h"
#include "io/volumes/volume_file.h"

#include <string.h>

/* A grid in memory; `bad` is set by the first access out of bounds, which reads 0. */
typedef struct pnanovdb_buf_t {
    const uint8_t* bytes;
    uint64_t size;
    bool* bad;
} pnanovdb_buf_t;

static inline void read_checked(pnanovdb_buf_t buf, uint64_t at, void* to, uint64_t size) {
    if (at <= buf.size && size <= buf.size - at) {
        memcpy(to, buf.bytes + at, size);
    } else {
        memset(to, 0, size);
        *buf.bad = true;
    }
}

static inline uint32_t pnanovdb_buf_read_uint32(pnanovdb_buf_t buf, uint64_t at) {
    uint32_t value;
    read_checked(buf, at & ~(uint64_t)3, &value, sizeof value);
    return value;
}

static inline uint64_t pnanovdb_buf_read_uint64(pnanovdb_buf_t buf, uint64_t at) {
    uint64_t value;
    read_checked(buf, at & ~(uint64_t)7, &value, sizeof value);
    return value;
}

typedef uint32_t pnanovdb_grid_type_t;
#define PNANOVDB_GRID_TYPE_GET(type, member) pnanovdb_grid_type_constants[type].member
#define PNANOVDB_C
#define PNANOVDB_BUF_CUSTOM
#include <nanovdb/PNanoVDB.h>

static const char* const type_names[] = {"unknown", "float", "double", "int16",  "int32", "int64", "vec3f",
                                         "vec3d",   "mask",  "half",   "uint32", "bool",  "rgba8", "fp4",
                                         "fp8",     "fp16",  "fpn",    "vec4f",  "vec4d", "index"};
enum { TYPE_NAMES = sizeof type_names / sizeof type_names[0] };

static const char* type_name(uint32_t type) {
    return type_names[type < TYPE_NAMES ? type : 0];
}

/* Values per voxel; 0 for unsupported types. */
static int32_t components_of(uint32_t type) {
    switch (type) {
    case PNANOVDB_GRID_TYPE_FLOAT:
    case PNANOVDB_GRID_TYPE_DOUBLE:
    case PNANOVDB_GRID_TYPE_HALF:
    case PNANOVDB_GRID_TYPE_FP4:
    case PNANOVDB_GRID_TYPE_FP8:
    case PNANOVDB_GRID_TYPE_FP16:
    case PNANOVDB_GRID_TYPE_FPN: return 1;
    case PNANOVDB_GRID_TYPE_VEC3F: return 3;
    default: return 0;
    }
}

ty_result ty_nanovdb_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                          int32_t* count) {
    ty_nanovdb_file file;
    const ty_result result = ty_nanovdb_open(context, path, &file);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < file.count && i < (size_t)capacity; ++i) {
        const ty_nanovdb_grid* grid = &file.grids[i];
        ty_vdb_entry entry = {.active_voxels = grid->active_voxels};
        memcpy(entry.name, grid->name, sizeof entry.name);
        snprintf(entry.type, sizeof entry.type, "%s", type_name(grid->type));
        memcpy(entry.lower, grid->lower, sizeof entry.lower);
        memcpy(entry.upper, grid->upper, sizeof entry.upper);
        memcpy(entry.voxel_size, grid->voxel_size, sizeof entry.voxel_size);
        entries[i] = entry;
    }
    *count = (int32_t)file.count;
    ty_nanovdb_close(&file);
    return TY_OK;
}

static ty_result find_grid(const ty_nanovdb_file* file, const char* name, const ty_nanovdb_grid** out) {
    char names[512] = "";
    size_t length = 0;
    for (size_t i = 0; i < file->count; ++i) {
        const ty_nanovdb_grid* grid = &file->grids[i];
        if (strcmp(grid->name, name) == 0) {
            *out = grid;
            if (components_of(grid->type) > 0) return TY_OK;
            return ty_fail(file->context, TY_ERROR_INPUT,
                           "%s: grid \"%s\" is of type %s, not float, half, double, fp4, fp8, fp16, fpn or vec3f",
                           file->path, name, type_name(grid->type));
        }
        if (length < sizeof names)
            length += (size_t)snprintf(names + length, sizeof names - length, "%s%s", i > 0 ? ", " : "", grid->name);
    }
    return ty_fail(file->context, TY_ERROR_INPUT, "%s: no grid \"%s\"; there %s %s", file->path, name,
                   file->count == 1 ? "is" : "are", file->count == 0 ? "none" : names);
}

/* Bytes of a mapped grid that are visited between two times that its pages are unloaded. */
enum { VISITED_MAX = 1 << 22 };

/* State of reading a tree. */
typedef struct tree {
    pnanovdb_buf_t buf;
    uint32_t type;
    int32_t component;
    ty_sparse* sparse;
    uint64_t visited_bytes;    /* total bytes of the nodes entered */
    const ty_mapping* mapping; /* NULL: the grid is in memory */
    uint64_t unloaded;         /* visited_bytes when the mapping's pages were unloaded last */
    bool no_memory;
} tree;

#define TY_LAYOUT(t, member) ((uint64_t)pnanovdb_grid_type_constants[(t)->type].member)

/* Value of a tile, or the background. */
static float read_value(const tree* t, uint64_t at) {
    const pnanovdb_address_t address = {at};
    switch (t->type) {
    case PNANOVDB_GRID_TYPE_DOUBLE: return (float)pnanovdb_read_double(t->buf, address);
    case PNANOVDB_GRID_TYPE_HALF: return ty_half_to_float((uint16_t)pnanovdb_read_half(t->buf, address));
    default: return pnanovdb_read_float(t->buf, pnanovdb_address_offset(address, 4 * (uint32_t)t->component));
    }
}

/* True if a node of `size` bytes lies within the grid and no bytes belong to several nodes. */
static bool enter_node(tree* t, uint64_t at, uint64_t size) {
    if (at > t->buf.size || size > t->buf.size - at || size > t->buf.size - t->visited_bytes) *t->buf.bad = true;
    if (*t->buf.bad) return false;
    t->visited_bytes += size;
    if (t->mapping != NULL && t->visited_bytes - t->unloaded > VISITED_MAX) {
        ty_mapping_unload(t->mapping, 0, t->mapping->size);
        t->unloaded = t->visited_bytes;
    }
    return true;
}

static bool check_added(tree* t, bool added) {
    if (!added) t->no_memory = *t->buf.bad = true;
    return added;
}

/* The codes of a variable-bit-width leaf follow it; log2 of their bits is in its flags. */
static uint64_t leaf_size(tree* t, uint64_t at) {
    const uint64_t size = TY_LAYOUT(t, leaf_size);
    if (t->type != PNANOVDB_GRID_TYPE_FPN) return size;
    const pnanovdb_leaf_handle_t leaf = {{at}};
    const uint32_t log2_bits = pnanovdb_leaf_get_bbox_dif_and_flags(t->buf, leaf) >> 29;
    if (log2_bits > 4) *t->buf.bad = true;
    return size + ((uint64_t)TY_LEAF_VOXELS / 8 << log2_bits);
}

static bool read_leaf(tree* t, uint64_t at, const int32_t origin[3]) {
    return enter_node(t, at, leaf_size(t, at)) &&
           check_added(t, ty_sparse_add_leaf(t->sparse, origin, t->buf.bytes + at + PNANOVDB_LEAF_OFF_VALUE_MASK, at));
}

/* Corner of slot n of an inner node with 2^log2 slots per side. */
static void slot_origin(const int32_t origin[3], uint32_t n, unsigned log2, int32_t side, int32_t to[3]) {
    const uint32_t last = (1u << log2) - 1;
    const uint32_t index[3] = {n >> 2 * log2, n >> log2 & last, n & last};
    for (int a = 0; a < 3; ++a) to[a] = origin[a] + (int32_t)index[a] * side;
}

static bool read_lower(tree* t, uint64_t at, const int32_t origin[3]) {
    enum { LOG2 = 4 };
    if (!enter_node(t, at, TY_LAYOUT(t, lower_size))) return false;
    const pnanovdb_lower_handle_t node = {{at}};
    const uint64_t table = at + TY_LAYOUT(t, lower_off_table);
    for (uint32_t n = 0; n < PNANOVDB_LOWER_TABLE_COUNT; ++n) {
        int32_t slot_corner[3];
        slot_origin(origin, n, LOG2, TY_LEAF_SIDE, slot_corner);
        const uint64_t slot = table + TY_LAYOUT(t, table_stride) * n;
        if (pnanovdb_lower_get_child_mask(t->buf, node, n)) {
            if (!read_leaf(t, at + pnanovdb_buf_read_uint64(t->buf, slot), slot_corner)) return false;
        } else {
            const bool active = pnanovdb_lower_get_value_mask(t->buf, node, n);
            if (!check_added(t, ty_sparse_add_tile(t->sparse, slot_corner, TY_LEAF_SIDE, active, read_value(t, slot))))
                return false;
        }
    }
    return true;
}

static bool read_upper(tree* t, uint64_t at, const int32_t origin[3]) {
    enum { LOG2 = 5 };
    if (!enter_node(t, at, TY_LAYOUT(t, upper_size))) return false;
    const pnanovdb_upper_handle_t node = {{at}};
    const uint64_t table = at + TY_LAYOUT(t, upper_off_table);
    for (uint32_t n = 0; n < PNANOVDB_UPPER_TABLE_COUNT; ++n) {
        int32_t slot_corner[3];
        slot_origin(origin, n, LOG2, TY_LOWER_SIDE, slot_corner);
        const uint64_t slot = table + TY_LAYOUT(t, table_stride) * n;
        if (pnanovdb_upper_get_child_mask(t->buf, node, n)) {
            if (!read_lower(t, at + pnanovdb_buf_read_uint64(t->buf, slot), slot_corner)) return false;
        } else {
            const bool active = pnanovdb_upper_get_value_mask(t->buf, node, n);
            if (!check_added(t, ty_sparse_add_tile(t->sparse, slot_corner, TY_LOWER_SIDE, active, read_value(t, slot))))
                return false;
        }
    }
    return true;
}

/* A key holds the three coordinates in units of an upper node, 21 bits each, z lowest. */
static void origin_of_key(uint64_t key, int32_t origin[3]) {
    enum { BITS = 21, SIDE_LOG2 = 12 };
    for (int a = 0; a < 3; ++a) origin[a] = (int32_t)((uint32_t)(key >> BITS * (2 - a)) << SIDE_LOG2);
}

static bool read_root(tree* t) {
    const pnanovdb_grid_handle_t grid = {{0}};
    const pnanovdb_root_handle_t root = pnanovdb_tree_get_root(t->buf, pnanovdb_grid_get_tree(t->buf, grid));
    const uint64_t at = root.address.byte_offset;
    const uint32_t tiles = pnanovdb_root_get_tile_count(t->buf, root);
    if (!enter_node(t, at, TY_LAYOUT(t, root_size)) ||
        !enter_node(t, at + TY_LAYOUT(t, root_size), TY_LAYOUT(t, root_tile_size) * tiles))
        return false;
    t->sparse->background = read_value(t, at + TY_LAYOUT(t, root_off_background));
    for (uint32_t n = 0; n < tiles; ++n) {
        const pnanovdb_root_tile_handle_t tile = pnanovdb_root_get_tile(t->type, root, n);
        const uint64_t child = (uint64_t)pnanovdb_root_tile_get_child(t->buf, tile);
        int32_t origin[3];
        origin_of_key(pnanovdb_root_tile_get_key(t->buf, tile), origin);
        if (!check_added(t, ty_sparse_add_root(t->sparse, origin))) return false;
        if (child != 0) {
            if (!read_upper(t, at + child, origin)) return false;
            continue;
        }
        const float value = read_value(t, tile.address.byte_offset + TY_LAYOUT(t, root_tile_off_value));
        const bool active = pnanovdb_root_tile_get_state(t->buf, tile) != 0;
        if (!check_added(t, ty_sparse_add_tile(t->sparse, origin, TY_UPPER_SIDE, active, value))) return false;
    }
    return !*t->buf.bad;
}

static float read_quantized(uint32_t type, pnanovdb_buf_t buf, pnanovdb_address_t table, const pnanovdb_coord_t* at) {
    switch (type) {
    case PNANOVDB_GRID_TYPE_FP4: return pnanovdb_leaf_fp4_read_float(buf, table, at);
    case PNANOVDB_GRID_TYPE_FP8: return pnanovdb_leaf_fp8_read_float(buf, table, at);
    case PNANOVDB_GRID_TYPE_FP16: return pnanovdb_leaf_fp16_read_float(buf, table, at);
    default: return pnanovdb_leaf_fpn_read_float(buf, table, at);
    }
}

static bool decode_leaf(const void* user, uint64_t leaf, void* to) {
    const tree* t = user;
    bool bad = false;
    const pnanovdb_buf_t buf = {t->buf.bytes, t->buf.size, &bad};
    const uint64_t table = leaf + TY_LAYOUT(t, leaf_off_table);
    const uint8_t* values = buf.bytes + table; /* read_leaf has validated the leaf's size */
    float* floats = to;
    switch (t->type) {
    case PNANOVDB_GRID_TYPE_FLOAT: memcpy(to, values, TY_LEAF_VOXELS * sizeof(float)); break;
    case PNANOVDB_GRID_TYPE_HALF: memcpy(to, values, TY_LEAF_VOXELS * sizeof(uint16_t)); break;
    case PNANOVDB_GRID_TYPE_VEC3F:
        for (int n = 0; n < TY_LEAF_VOXELS; ++n)
            memcpy(floats + n, values + sizeof(float) * (size_t)(3 * n + t->component), sizeof(float));
        break;
    case PNANOVDB_GRID_TYPE_DOUBLE:
        for (int n = 0; n < TY_LEAF_VOXELS; ++n) {
            double value;
            memcpy(&value, values + sizeof value * (size_t)n, sizeof value);
            floats[n] = (float)value;
        }
        break;
    default:
        for (int32_t n = 0; n < TY_LEAF_VOXELS; ++n) {
            const pnanovdb_coord_t at = {n >> 6, n >> 3 & 7, n & 7};
            floats[n] = read_quantized(t->type, buf, (pnanovdb_address_t){table}, &at);
        }
    }
    return !bad;
}

/* Checks that a grid's header agrees with the segment's metadata; *map is its transform. */
static ty_result check_head(const ty_nanovdb_file* file, const ty_nanovdb_grid* entry, const tree* t, ty_affine* map) {
    const pnanovdb_grid_handle_t grid = {{0}};
    const pnanovdb_map_handle_t stored = pnanovdb_grid_get_map(t->buf, grid);
    *map = ty_affine_identity();
    for (uint32_t r = 0; r < 3; ++r) {
        for (uint32_t c = 0; c < 3; ++c) map->m[4 * r + c] = pnanovdb_map_get_matd(t->buf, stored, 3 * r + c);
        map->m[4 * r + 3] = pnanovdb_map_get_vecd(t->buf, stored, r);
    }
    if (*t->buf.bad || pnanovdb_grid_get_grid_type(t->buf, grid) != entry->type ||
        pnanovdb_version_get_major(pnanovdb_grid_get_version(t->buf, grid)) != PNANOVDB_MAJOR_VERSION_NUMBER)
        return ty_nanovdb_damaged(file, entry->name);
    ty_affine inverse;
    if (ty_affine_invert(map, &inverse)) return TY_OK;
    return ty_fail(file->context, TY_ERROR_INPUT, "%s: the transform of grid \"%s\" cannot be inverted", file->path,
                   entry->name);
}

static ty_result read_tree(const ty_nanovdb_file* file, const ty_nanovdb_grid* entry, int32_t component,
                           const uint8_t* bytes, const ty_mapping* mapping, const ty_grid_plan* plan, ty_grid** out) {
    bool bad = false;
    ty_affine map;
    ty_sparse sparse = ty_sparse_begin(file->context, file->path, entry->name);
    sparse.plan = *plan;
    sparse.measures = plan->part;
    sparse.type = entry->type == PNANOVDB_GRID_TYPE_HALF ? TY_GRID_F16 : TY_GRID_F32;
    tree t = {.buf = {bytes, entry->size, &bad},
              .type = entry->type,
              .component = component,
              .sparse = &sparse,
              .mapping = mapping};
    ty_result result = check_head(file, entry, &t, &map);
    bool read = result == TY_OK && read_root(&t);
    if (read && plan->part) {
        ty_sparse_restart(&sparse);
        t.visited_bytes = t.unloaded = 0;
        read = read_root(&t);
    }
    if (result == TY_OK && !read) result = t.no_memory ? TY_ERROR_MEMORY : ty_nanovdb_damaged(file, entry->name);
    if (result == TY_OK) result = ty_sparse_make_grid(&sparse, decode_leaf, &t, &map, out);
    ty_sparse_end(&sparse);
    return result;
}

ty_result ty_nanovdb_read(ty_context* context, const char* path, const char* name, int32_t component,
                          const ty_grid_plan* plan, ty_grid** out) {
    ty_nanovdb_file file;
    ty_result result = ty_nanovdb_open(context, path, &file);
    if (result != TY_OK) return result;
    const ty_nanovdb_grid* grid = NULL;
    result = find_grid(&file, name, &grid);
    if (result == TY_OK) result = ty_check_component(context, path, name, component, components_of(grid->type));
    uint8_t* loaded = NULL;
    const uint8_t* mapped = NULL;
    ty_mapping* mapping = NULL;
    if (result == TY_OK && plan->part) result = ty_nanovdb_map(&file, grid, &mapping, &mapped);
    if (result == TY_OK && !plan->part) result = ty_nanovdb_load(&file, grid, &loaded);
    if (result == TY_OK) result = read_tree(&file, grid, component, plan->part ? mapped : loaded, mapping, plan, out);
    if (loaded != NULL) ty_free_array(context, loaded, grid->size, 1);
    ty_mapping_close(mapping);
    ty_nanovdb_close(&file);
    return result;
}

ty_result ty_nanovdb_components(ty_context* context, const char* path, const char* name, int32_t* out) {
    ty_nanovdb_file file;
    ty_result result = ty_nanovdb_open(context, path, &file);
    if (result != TY_OK) return result;
    const ty_nanovdb_grid* grid = NULL;
    result = find_grid(&file, name, &grid);
    if (result == TY_OK) *out = components_of(grid->type);
    ty_nanovdb_close(&file);
    return result;
}

ty_result ty_nanovdb_write(ty_context* context, const ty_grid* grid, const char* grid_name, const char* codec,
                           const char* path) {
    if (grid == NULL || grid_name == NULL || grid_name[0] == '\0' || strlen(grid_name) >= TY_NANOVDB_NAME_SIZE)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "ty_nanovdb_write: the grid is NULL or its name not 1..%d characters",
                       (int)TY_NANOVDB_NAME_SIZE - 1);
    if (codec == NULL || (strcmp(codec, "none") != 0 && strcmp(codec, "zip") != 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "the NanoVDB codec is \"%s\", not none or zip",
                       codec == NULL ? "" : codec);
    ty_output output;
    ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    result = ty_nanovdb_build(context, grid, grid_name, strcmp(codec, "zip") == 0, &output);
    if (result == TY_OK) return ty_output_commit(context, &output);
    ty_output_discard(context, &output);
    return result;
}
