/* Container of OpenVDB files, formats 222 to 224: header, metadata, grid descriptors, transforms. Little-endian. */
#define _POSIX_C_SOURCE 200809L
#include "io/volumes/vdb.h"

#include "base/context.h"
#include "io/file.h"

#include <string.h>

enum {
    VERSION_OLDEST = 222, /* first version with the node layout and compression described here */
    VERSION_NEWEST = 224,
    DESCRIPTOR_SIZE_MIN = 36
};

/* A position in the file. The first read past the end, or of an invalid value, sets `bad`, and all later reads fail. */
typedef struct cursor {
    FILE* stream;
    uint64_t at, size;
    bool bad;
} cursor;

static bool mark_bad(cursor* c) {
    c->bad = true;
    return false;
}

static bool read_bytes(cursor* c, void* to, uint64_t size) {
    if (c->bad || size > c->size - c->at || fread(to, 1, (size_t)size, c->stream) != size) return mark_bad(c);
    c->at += size;
    return true;
}

static bool move_to(cursor* c, uint64_t at) {
    if (c->bad || at > c->size || fseeko(c->stream, (off_t)at, SEEK_SET) != 0) return mark_bad(c);
    c->at = at;
    return true;
}

static bool skip(cursor* c, uint64_t size) {
    if (c->bad || size > c->size - c->at) return mark_bad(c);
    return size == 0 || move_to(c, c->at + size);
}

static uint32_t read_u32(cursor* c) {
    uint32_t value = 0;
    return read_bytes(c, &value, sizeof value) ? value : 0;
}

static int64_t read_i64(cursor* c) {
    int64_t value = 0;
    return read_bytes(c, &value, sizeof value) ? value : 0;
}

/* Reads a counted string; excess is truncated. */
static bool read_text(cursor* c, char text[TY_VDB_NAME_SIZE]) {
    const uint32_t length = read_u32(c);
    const uint32_t stored = length < TY_VDB_NAME_SIZE ? length : TY_VDB_NAME_SIZE - 1;
    memset(text, 0, TY_VDB_NAME_SIZE);
    return read_bytes(c, text, stored) && skip(c, length - stored);
}

/* The file distinguishes grids of one name as "density<RS>1"; the displayed name is "density[1]". */
static void format_suffix(char name[TY_VDB_NAME_SIZE]) {
    char* separator = strchr(name, 0x1e);
    const size_t length = strlen(name);
    if (separator == NULL || length + 2 > TY_VDB_NAME_SIZE) return;
    *separator = '[';
    name[length] = ']';
    name[length + 1] = '\0';
}

/* Reads metadata: statistics if grid is given; all other entries are skipped. */
static bool read_metadata(cursor* c, ty_vdb_grid* grid) {
    unsigned found = 0;
    for (uint32_t count = read_u32(c); count > 0 && !c->bad; --count) {
        char key[TY_VDB_NAME_SIZE], type[TY_VDB_NAME_SIZE];
        if (!read_text(c, key) || !read_text(c, type)) return false;
        const uint32_t size = read_u32(c);
        if (grid != NULL && strcmp(key, "file_bbox_min") == 0 && size == sizeof grid->lower)
            found |= read_bytes(c, grid->lower, size) ? 1u : 0u;
        else if (grid != NULL && strcmp(key, "file_bbox_max") == 0 && size == sizeof grid->upper)
            found |= read_bytes(c, grid->upper, size) ? 2u : 0u;
        else if (grid != NULL && strcmp(key, "file_voxel_count") == 0 && size == sizeof grid->active_voxels)
            found |= read_bytes(c, &grid->active_voxels, size) ? 4u : 0u;
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

/* Reads a map's type, then its numbers. Matrices act on row vectors. */
static bool read_transform(cursor* c, ty_vdb_grid* grid) {
    char type[TY_VDB_NAME_SIZE];
    double values[18];
    if (!read_text(c, type)) return false;
    grid->affine = true;
    grid->index_to_world = ty_affine_identity();
    if (strcmp(type, "ScaleMap") == 0 || strcmp(type, "UniformScaleMap") == 0) {
        if (!read_bytes(c, values, 15 * sizeof *values)) return false;
        set_scale(&grid->index_to_world, values);
    } else if (strcmp(type, "TranslationMap") == 0) {
        if (!read_bytes(c, values, 3 * sizeof *values)) return false;
        set_translation(&grid->index_to_world, values);
    } else if (strcmp(type, "ScaleTranslateMap") == 0 || strcmp(type, "UniformScaleTranslateMap") == 0) {
        if (!read_bytes(c, values, 18 * sizeof *values)) return false;
        set_translation(&grid->index_to_world, values);
        set_scale(&grid->index_to_world, values + 3);
    } else if (strcmp(type, "AffineMap") == 0 || strcmp(type, "UnitaryMap") == 0) {
        if (!read_bytes(c, values, 16 * sizeof *values)) return false;
        for (int r = 0; r < 3; ++r)
            for (int k = 0; k < 4; ++k) grid->index_to_world.m[4 * r + k] = values[4 * k + r];
    } else {
        grid->affine = false;
        return true;
    }
    grid->tree = c->at;
    return true;
}

/* Reads one descriptor and its grid's header; the cursor moves to the next descriptor. */
static bool read_grid(cursor* c, ty_vdb_grid* grid) {
    static const char half_suffix[] = "_HalfFloat";
    read_text(c, grid->name);
    read_text(c, grid->type);
    read_text(c, grid->parent);
    format_suffix(grid->name);
    format_suffix(grid->parent);
    char* suffix = strstr(grid->type, half_suffix);
    if (suffix != NULL) {
        *suffix = '\0';
        grid->half = true;
    }
    const int64_t head = read_i64(c);
    read_i64(c); /* offset of the voxel values, which the tree reader finds by itself */
    const int64_t end = read_i64(c);
    if (c->bad || head < (int64_t)c->at || end < head || (uint64_t)end > c->size) return mark_bad(c);
    grid->end = (uint64_t)end;
    move_to(c, (uint64_t)head);
    grid->compression = read_u32(c);
    if (!read_metadata(c, grid) || !read_transform(c, grid) || c->at > grid->end) return mark_bad(c);
    return move_to(c, grid->end);
}

ty_result ty_vdb_damaged(const ty_vdb_file* file, const char* what) {
    return ty_fail(file->context, TY_ERROR_INPUT, "%s: damaged or cut short (%s)", file->path, what);
}

static ty_result read_header(ty_vdb_file* file, cursor* c) {
    uint64_t found = 0;
    if (!read_bytes(c, &found, sizeof found) || found != TY_VDB_MAGIC)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: not an OpenVDB file", file->path);
    file->version = read_u32(c);
    if (!c->bad && (file->version < VERSION_OLDEST || file->version > VERSION_NEWEST))
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: OpenVDB file format %u; %d to %d can be read", file->path,
                       file->version, (int)VERSION_OLDEST, (int)VERSION_NEWEST);
    file->library[0] = read_u32(c);
    file->library[1] = read_u32(c);
    uint8_t has_offsets = 0;
    read_bytes(c, &has_offsets, 1);
    skip(c, TY_VDB_UUID_SIZE);
    if (!read_metadata(c, NULL)) return ty_vdb_damaged(file, "header");
    if (has_offsets == 0)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: written as a stream, without the offsets of its grids",
                       file->path);
    return TY_OK;
}

static ty_result read_grids(ty_vdb_file* file, cursor* c) {
    const uint32_t count = read_u32(c);
    if (c->bad || count > c->size / DESCRIPTOR_SIZE_MIN) return ty_vdb_damaged(file, "number of grids");
    for (uint32_t i = 0; i < count; ++i) {
        if (!ty_grow_array(file->context, (void**)&file->grids, &file->capacity, file->count, sizeof *file->grids))
            return TY_ERROR_MEMORY;
        ty_vdb_grid* grid = &file->grids[file->count];
        memset(grid, 0, sizeof *grid);
        if (!read_grid(c, grid)) return ty_vdb_damaged(file, "grid descriptor");
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

ty_result ty_vdb_load(const ty_vdb_file* file, const ty_vdb_grid* grid, uint8_t** bytes, size_t* size) {
    const size_t length = (size_t)(grid->end - grid->tree);
    uint8_t* loaded = ty_alloc_array(file->context, length, 1, false);
    if (loaded == NULL) return TY_ERROR_MEMORY;
    cursor c = {.stream = file->stream, .size = file->size};
    if (!move_to(&c, grid->tree) || !read_bytes(&c, loaded, length)) {
        ty_free_array(file->context, loaded, length, 1);
        return ty_vdb_damaged(file, grid->name);
    }
    *bytes = loaded;
    *size = length;
    return TY_OK;
}

void ty_vdb_close(ty_vdb_file* file) {
    if (file->stream != NULL) fclose(file->stream);
    ty_free_array(file->context, file->grids, file->capacity, sizeof *file->grids);
    *file = (ty_vdb_file){0};
}
