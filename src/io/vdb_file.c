/* The container of OpenVDB files, formats 222 to 224: header, metadata, grid descriptors, transforms, and a walk over
 * trees that checks every count and length before OpenVDB sees them. Little-endian throughout. */
#define _POSIX_C_SOURCE 200809L
#include "io/vdb.h"

#include "base/context.h"
#include "io/file.h"

#include <stdio.h>
#include <string.h>

enum {
    VERSION_OLDEST = 222, /* the first whose nodes and compression are stored as described here */
    VERSION_NEWEST = 224,
    UUID_SIZE = 36,
    DESCRIPTOR_SIZE_MIN = 36,
    COMPRESS_ZIP = 1,
    COMPRESS_MASK = 2,
    COMPRESS_BLOSC = 4
};

static const uint64_t magic = 0x56444220;

/* A position in the file. The first read past the end, or of something impossible, sets bad; all later ones fail. */
typedef struct cursor {
    FILE* stream;
    uint64_t at, size;
    bool bad;
} cursor;

static bool spoil(cursor* c) {
    c->bad = true;
    return false;
}

static bool take(cursor* c, void* to, uint64_t size) {
    if (c->bad || size > c->size - c->at || fread(to, 1, (size_t)size, c->stream) != size) return spoil(c);
    c->at += size;
    return true;
}

static bool move_to(cursor* c, uint64_t at) {
    if (c->bad || at > c->size || fseeko(c->stream, (off_t)at, SEEK_SET) != 0) return spoil(c);
    c->at = at;
    return true;
}

static bool skip(cursor* c, uint64_t size) {
    if (c->bad || size > c->size - c->at) return spoil(c);
    return size == 0 || move_to(c, c->at + size);
}

static uint32_t take_u32(cursor* c) {
    uint32_t value = 0;
    return take(c, &value, sizeof value) ? value : 0;
}

static int64_t take_i64(cursor* c) {
    int64_t value = 0;
    return take(c, &value, sizeof value) ? value : 0;
}

/* A counted string; what does not fit is cut. */
static bool take_text(cursor* c, char text[TY_VDB_NAME_SIZE]) {
    const uint32_t length = take_u32(c);
    const uint32_t kept = length < TY_VDB_NAME_SIZE ? length : TY_VDB_NAME_SIZE - 1;
    memset(text, 0, TY_VDB_NAME_SIZE);
    return take(c, text, kept) && skip(c, length - kept);
}

/* "density<RS>1" is how the file tells grids of one name apart; shown as "density[1]". */
static void show_suffix(char name[TY_VDB_NAME_SIZE]) {
    char* separator = strchr(name, 0x1e);
    const size_t length = strlen(name);
    if (separator == NULL || length + 2 > TY_VDB_NAME_SIZE) return;
    *separator = '[';
    name[length] = ']';
    name[length + 1] = '\0';
}

/* Metadata: statistics are kept when grid is given, everything else is passed over. */
static bool take_metadata(cursor* c, ty_vdb_grid* grid) {
    unsigned found = 0;
    for (uint32_t count = take_u32(c); count > 0 && !c->bad; --count) {
        char key[TY_VDB_NAME_SIZE], type[TY_VDB_NAME_SIZE];
        if (!take_text(c, key) || !take_text(c, type)) return false;
        const uint32_t size = take_u32(c);
        if (grid != NULL && strcmp(key, "file_bbox_min") == 0 && size == sizeof grid->lower)
            found |= take(c, grid->lower, size) ? 1u : 0u;
        else if (grid != NULL && strcmp(key, "file_bbox_max") == 0 && size == sizeof grid->upper)
            found |= take(c, grid->upper, size) ? 2u : 0u;
        else if (grid != NULL && strcmp(key, "file_voxel_count") == 0 && size == sizeof grid->active_voxels)
            found |= take(c, &grid->active_voxels, size) ? 4u : 0u;
        else
            skip(c, size);
    }
    if (grid != NULL) grid->has_statistics = found == 7;
    return !c->bad;
}

static void set_scale(ty_affine* map, const double scale[3]) {
    for (int a = 0; a < 3; ++a) map->m[5 * a] = scale[a];
}

static void set_translation(ty_affine* map, const double translation[3]) {
    for (int a = 0; a < 3; ++a) map->m[4 * a + 3] = translation[a];
}

/* A map's type, then its numbers. Matrices act on row vectors. */
static bool take_transform(cursor* c, ty_vdb_grid* grid) {
    char type[TY_VDB_NAME_SIZE];
    double values[18];
    if (!take_text(c, type)) return false;
    grid->affine = true;
    grid->index_to_world = ty_affine_identity();
    if (strcmp(type, "ScaleMap") == 0 || strcmp(type, "UniformScaleMap") == 0) {
        if (!take(c, values, 15 * sizeof *values)) return false;
        set_scale(&grid->index_to_world, values);
    } else if (strcmp(type, "TranslationMap") == 0) {
        if (!take(c, values, 3 * sizeof *values)) return false;
        set_translation(&grid->index_to_world, values);
    } else if (strcmp(type, "ScaleTranslateMap") == 0 || strcmp(type, "UniformScaleTranslateMap") == 0) {
        if (!take(c, values, 18 * sizeof *values)) return false;
        set_translation(&grid->index_to_world, values);
        set_scale(&grid->index_to_world, values + 3);
    } else if (strcmp(type, "AffineMap") == 0 || strcmp(type, "UnitaryMap") == 0) {
        if (!take(c, values, 16 * sizeof *values)) return false;
        for (int r = 0; r < 3; ++r)
            for (int k = 0; k < 4; ++k) grid->index_to_world.m[4 * r + k] = values[4 * k + r];
    } else {
        grid->affine = false;
        return true;
    }
    grid->tree = c->at;
    return true;
}

/* One descriptor and the head of its grid; leaves the cursor at the next descriptor. */
static bool take_grid(cursor* c, ty_vdb_grid* grid) {
    static const char half_suffix[] = "_HalfFloat";
    take_text(c, grid->name);
    take_text(c, grid->type);
    take_text(c, grid->parent);
    show_suffix(grid->name);
    show_suffix(grid->parent);
    char* suffix = strstr(grid->type, half_suffix);
    if (suffix != NULL) {
        *suffix = '\0';
        grid->half = true;
    }
    const int64_t head = take_i64(c);
    take_i64(c); /* where the voxel values begin; the walk finds them by itself */
    const int64_t end = take_i64(c);
    if (c->bad || head < (int64_t)c->at || end < head || (uint64_t)end > c->size) return spoil(c);
    grid->end = (uint64_t)end;
    move_to(c, (uint64_t)head);
    grid->compression = take_u32(c);
    if (!take_metadata(c, grid) || !take_transform(c, grid) || c->at > grid->end) return spoil(c);
    return move_to(c, grid->end);
}

static ty_result damaged(const ty_vdb_file* file, const char* what) {
    return ty_fail(file->context, TY_ERROR_INPUT, "%s: damaged or cut short (%s)", file->path, what);
}

static ty_result read_header(ty_vdb_file* file, cursor* c) {
    uint64_t found = 0;
    if (!take(c, &found, sizeof found) || found != magic)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: not an OpenVDB file", file->path);
    file->version = take_u32(c);
    if (!c->bad && (file->version < VERSION_OLDEST || file->version > VERSION_NEWEST))
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: OpenVDB file format %u; %d to %d can be read", file->path,
                       file->version, (int)VERSION_OLDEST, (int)VERSION_NEWEST);
    file->library[0] = take_u32(c);
    file->library[1] = take_u32(c);
    uint8_t has_offsets = 0;
    take(c, &has_offsets, 1);
    skip(c, UUID_SIZE);
    if (!take_metadata(c, NULL)) return damaged(file, "header");
    if (has_offsets == 0)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: written as a stream, without the offsets of its grids",
                       file->path);
    return TY_OK;
}

static ty_result read_grids(ty_vdb_file* file, cursor* c) {
    const uint32_t count = take_u32(c);
    if (c->bad || count > c->size / DESCRIPTOR_SIZE_MIN) return damaged(file, "number of grids");
    for (uint32_t i = 0; i < count; ++i) {
        if (!ty_grow_array(file->context, (void**)&file->grids, &file->capacity, file->count, sizeof *file->grids))
            return TY_ERROR_MEMORY;
        ty_vdb_grid* grid = &file->grids[file->count];
        memset(grid, 0, sizeof *grid);
        if (!take_grid(c, grid)) return damaged(file, "grid descriptor");
        ++file->count;
    }
    return TY_OK;
}

ty_result ty_vdb_open(ty_context* context, const char* path, ty_vdb_file* file) {
    *file = (ty_vdb_file){.context = context, .path = path};
    FILE* stream = NULL;
    ty_result result = ty_open_file(context, path, &stream, &file->size);
    if (result != TY_OK) return result;
    file->stream = stream;
    cursor c = {.stream = stream, .size = file->size};
    result = read_header(file, &c);
    if (result == TY_OK) result = read_grids(file, &c);
    if (result != TY_OK) ty_vdb_close(file);
    return result;
}

void ty_vdb_close(ty_vdb_file* file) {
    if (file->stream != NULL) fclose(file->stream);
    ty_free_array(file->context, file->grids, file->capacity, sizeof *file->grids);
    *file = (ty_vdb_file){0};
}

enum { LEAF_SLOTS = 512, NODE_SLOTS_MAX = 32768, BLOSC_HEAD = 16, COUNT_SIZE = 8 };

/* What the walk over one tree needs. */
typedef struct walk {
    cursor cursor;
    uint32_t compression;
    uint64_t value_size, stored_size; /* bytes of a value on its own, and of one among a node's compressed values */
    bool half;
    uint64_t leaves;
    uint8_t* block; /* room for any compressed block with its byte count */
} walk;

/* What a codec at most makes of raw bytes. */
static uint64_t packed_size_max(uint64_t raw) {
    return raw + raw / 256 + 64;
}

/* The rest of a compressed block. Blosc believes its own header (flags, raw size, block size, compressed size), so
 * that must be right; an inner node's values must also decode, since OpenVDB loses the nodes read so far otherwise. */
static bool check_compressed(walk* w, int64_t stored, uint64_t raw, bool inner) {
    cursor* c = &w->cursor;
    const bool blosc = (w->compression & COMPRESS_BLOSC) != 0;
    if ((uint64_t)stored > packed_size_max(raw) || (blosc && stored < BLOSC_HEAD)) return spoil(c);
    const uint64_t needed = inner ? (uint64_t)stored : blosc ? BLOSC_HEAD : 0;
    memcpy(w->block, &stored, COUNT_SIZE);
    if (!take(c, w->block + COUNT_SIZE, needed)) return false;
    if (blosc) {
        uint32_t head[4];
        memcpy(head, w->block + COUNT_SIZE, sizeof head);
        if (head[1] != raw || head[2] == 0 || head[3] != stored) return spoil(c);
    }
    if (inner && !ty_openvdb_decodes(blosc, w->block, COUNT_SIZE + needed, raw)) return spoil(c);
    return skip(c, (uint64_t)stored - needed);
}

/* count values as one block: plain, or a byte count (negative for stored, positive for compressed) and the bytes. */
static bool check_block(walk* w, uint64_t count, bool inner) {
    cursor* c = &w->cursor;
    const uint64_t raw = count * w->stored_size;
    if (w->half && count == 0) return true;
    if ((w->compression & (COMPRESS_BLOSC | COMPRESS_ZIP)) == 0) return skip(c, raw);
    const int64_t stored = take_i64(c);
    if (c->bad) return false;
    if (stored <= 0) return stored == -(int64_t)raw ? skip(c, raw) : spoil(c);
    return check_compressed(w, stored, raw, inner);
}

static uint64_t count_bits(const uint8_t* mask, uint64_t bytes) {
    uint64_t count = 0;
    for (uint64_t i = 0; i < bytes; i += sizeof(uint64_t)) {
        uint64_t word;
        memcpy(&word, mask + i, sizeof word);
        count += (uint64_t)__builtin_popcountll(word);
    }
    return count;
}

/* The values of a node with slots places, of which active are on: how inactive values are coded (0..6), up to two of
 * those values, a mask that selects between them, then the block. */
static bool check_values(walk* w, uint64_t slots, uint64_t active) {
    uint8_t coding = 0;
    if (!take(&w->cursor, &coding, 1) || coding > 6) return spoil(&w->cursor);
    const bool one = coding == 2 || coding == 4 || coding == 5, two = coding == 5;
    if (!skip(&w->cursor, ((uint64_t)one + two) * w->value_size)) return false;
    if (coding >= 3 && coding <= 5 && !skip(&w->cursor, slots / 8)) return false;
    return check_block(w, (w->compression & COMPRESS_MASK) != 0 && coding != 6 ? active : slots, slots > LEAF_SLOTS);
}

/* A node with 2^(3 log2) slots: child and value masks, values, then the children in turn. Leaves have a mask alone. */
static bool check_node(walk* w, unsigned log2) {
    const uint64_t slots = (uint64_t)1 << 3 * log2;
    if (slots == LEAF_SLOTS) {
        ++w->leaves;
        return skip(&w->cursor, slots / 8);
    }
    uint8_t mask[NODE_SLOTS_MAX / 8];
    if (!take(&w->cursor, mask, slots / 8)) return false;
    const uint64_t children = count_bits(mask, slots / 8);
    if (!take(&w->cursor, mask, slots / 8) || !check_values(w, slots, count_bits(mask, slots / 8))) return false;
    for (uint64_t i = 0; i < children; ++i)
        if (!check_node(w, log2 - 1)) return false;
    return true;
}

static bool check_root(walk* w) {
    enum { ROOT_CHILD_LOG2 = 5, ORIGIN_SIZE = 12 };
    cursor* c = &w->cursor;
    if (take_u32(c) != 1) return spoil(c); /* buffers */
    skip(c, w->value_size);                /* background */
    const uint32_t tiles = take_u32(c), children = take_u32(c);
    for (uint32_t i = 0; i < tiles && !c->bad; ++i) {
        uint8_t active = 0;
        if (skip(c, ORIGIN_SIZE + w->value_size) && take(c, &active, 1) && active > 1) spoil(c);
    }
    for (uint32_t i = 0; i < children && !c->bad; ++i)
        if (skip(c, ORIGIN_SIZE)) check_node(w, ROOT_CHILD_LOG2);
    return !c->bad;
}

ty_result ty_vdb_check_tree(const ty_vdb_file* file, const ty_vdb_grid* grid, size_t value_size) {
    const size_t block_size = COUNT_SIZE + packed_size_max(NODE_SLOTS_MAX * sizeof(double));
    walk w = {.cursor = {.stream = file->stream, .size = grid->end},
              .compression = grid->compression,
              .value_size = value_size,
              .stored_size = grid->half ? sizeof(uint16_t) : value_size,
              .half = grid->half,
              .block = ty_alloc_array(file->context, block_size, 1, false)};
    if (w.block == NULL) return TY_ERROR_MEMORY;
    move_to(&w.cursor, grid->tree);
    check_root(&w);
    for (uint64_t i = 0; i < w.leaves && !w.cursor.bad; ++i) {
        uint8_t mask[LEAF_SLOTS / 8];
        if (take(&w.cursor, mask, sizeof mask)) check_values(&w, LEAF_SLOTS, count_bits(mask, sizeof mask));
    }
    ty_free_array(file->context, w.block, block_size, 1);
    return w.cursor.bad ? damaged(file, grid->name) : TY_OK;
}
