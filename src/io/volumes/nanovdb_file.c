/* Container of NanoVDB files: segments, each with a header, grid metadata, then the grids, plain or zip.
 * Little-endian. */
#define _POSIX_C_SOURCE 200809L
#include "io/volumes/nanovdb.h"

#include "base/context.h"
#include "base/mapping.h"
#include "io/file.h"
#include "io/volumes/volume_file.h"

#include <stdio.h>
#include <string.h>
#include <zlib.h>

enum {
    VERSION_MAJOR = 32,
    SEGMENT_SIZE = 16,
    METADATA_SIZE = 176,
    GRIDS_MAX = 65536,
    /* Offsets in a grid's metadata. */
    OFFSET_SIZE = 0,
    OFFSET_STORED = 8,
    OFFSET_VOXELS = 24,
    OFFSET_TYPE = 32,
    OFFSET_LOWER = 88,
    OFFSET_UPPER = 100,
    OFFSET_VOXEL_SIZE = 112,
    OFFSET_NAME_SIZE = 136,
};

ty_result ty_nanovdb_damaged(const ty_nanovdb_file* file, const char* what) {
    return ty_fail(file->context, TY_ERROR_INPUT, "%s: damaged or cut short (%s)", file->path, what);
}

bool ty_is_nanovdb(const char* path) {
    char head[7] = "";
    return path != NULL && ty_read_head(path, head, sizeof head) == sizeof head &&
           memcmp(head, "NanoVDB", sizeof head) == 0;
}

static bool read_bytes(const ty_nanovdb_file* file, uint64_t* at, void* to, uint64_t size) {
    if (size > file->size - *at || fread(to, 1, (size_t)size, file->stream) != size) return false;
    *at += size;
    return true;
}

static bool move_to(const ty_nanovdb_file* file, uint64_t* at, uint64_t to) {
    if (to > file->size || fseeko(file->stream, (off_t)to, SEEK_SET) != 0) return false;
    *at = to;
    return true;
}

/* Reads a name of `size` bytes with its zero; excess is truncated. */
static bool read_name(const ty_nanovdb_file* file, uint64_t* at, uint32_t size, char name[TY_NANOVDB_NAME_SIZE]) {
    const uint32_t stored = size < TY_NANOVDB_NAME_SIZE ? size : TY_NANOVDB_NAME_SIZE - 1;
    memset(name, 0, TY_NANOVDB_NAME_SIZE);
    return read_bytes(file, at, name, stored) && move_to(file, at, *at + (size - stored));
}

static bool read_metadata(const ty_nanovdb_file* file, uint64_t* at, uint32_t codec, ty_nanovdb_grid* grid) {
    uint8_t bytes[METADATA_SIZE];
    uint32_t name_size;
    if (!read_bytes(file, at, bytes, sizeof bytes)) return false;
    *grid = (ty_nanovdb_grid){.codec = codec};
    memcpy(&grid->size, bytes + OFFSET_SIZE, sizeof grid->size);
    memcpy(&grid->stored_size, bytes + OFFSET_STORED, sizeof grid->stored_size);
    memcpy(&grid->active_voxels, bytes + OFFSET_VOXELS, sizeof grid->active_voxels);
    memcpy(&grid->type, bytes + OFFSET_TYPE, sizeof grid->type);
    memcpy(grid->lower, bytes + OFFSET_LOWER, sizeof grid->lower);
    memcpy(grid->upper, bytes + OFFSET_UPPER, sizeof grid->upper);
    memcpy(grid->voxel_size, bytes + OFFSET_VOXEL_SIZE, sizeof grid->voxel_size);
    memcpy(&name_size, bytes + OFFSET_NAME_SIZE, sizeof name_size);
    return read_name(file, at, name_size, grid->name);
}

static ty_result check_segment(const ty_nanovdb_file* file, const uint8_t head[SEGMENT_SIZE]) {
    uint32_t version;
    uint16_t codec;
    memcpy(&version, head + 8, sizeof version);
    memcpy(&codec, head + 14, sizeof codec);
    if (memcmp(head, "NanoVDB0", 8) != 0 && memcmp(head, "NanoVDB2", 8) != 0)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: not a NanoVDB file", file->path);
    if (version >> 21 != VERSION_MAJOR)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: NanoVDB version %u; %d can be read", file->path,
                       version >> 21, (int)VERSION_MAJOR);
    if (codec == TY_NANOVDB_BLOSC)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: compressed by blosc; NanoVDB can be read plain or zip",
                       file->path);
    return codec > TY_NANOVDB_BLOSC ? ty_nanovdb_damaged(file, "codec") : TY_OK;
}

/* Reads a segment's header and metadata; the stream ends up after its grids. */
static ty_result read_segment(ty_nanovdb_file* file, uint64_t* at) {
    uint8_t head[SEGMENT_SIZE];
    uint16_t grids, codec;
    if (!read_bytes(file, at, head, sizeof head))
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: not a NanoVDB file", file->path);
    const ty_result result = check_segment(file, head);
    if (result != TY_OK) return result;
    memcpy(&grids, head + 12, sizeof grids);
    memcpy(&codec, head + 14, sizeof codec);
    const size_t first = file->count;
    for (int i = 0; i < grids; ++i) {
        if (!ty_grow_array(file->context, (void**)&file->grids, &file->capacity, file->count, sizeof *file->grids))
            return TY_ERROR_MEMORY;
        if (!read_metadata(file, at, codec, &file->grids[file->count]))
            return ty_nanovdb_damaged(file, "what is said of a grid");
        ++file->count;
    }
    for (size_t i = first; i < file->count; ++i) {
        file->grids[i].at = *at;
        if (file->grids[i].stored_size > file->size - *at || !move_to(file, at, *at + file->grids[i].stored_size))
            return ty_nanovdb_damaged(file, file->grids[i].name);
    }
    return TY_OK;
}

ty_result ty_nanovdb_open(ty_context* context, const char* path, ty_nanovdb_file* file) {
    *file = (ty_nanovdb_file){.context = context, .path = path};
    FILE* stream = NULL;
    ty_result result = ty_open_file(context, path, &stream, &file->size);
    if (result != TY_OK) return result;
    file->stream = stream;
    uint64_t at = 0;
    do result = read_segment(file, &at);
    while (result == TY_OK && at < file->size && file->count < GRIDS_MAX);
    if (result != TY_OK) ty_nanovdb_close(file);
    return result;
}

void ty_nanovdb_close(ty_nanovdb_file* file) {
    if (file->stream != NULL) fclose(file->stream);
    ty_free_array(file->context, file->grids, file->capacity, sizeof *file->grids);
    *file = (ty_nanovdb_file){0};
}

/* Zip block: a byte count, then the bytes. */
static bool unpack(const uint8_t* stored, uint64_t stored_size, uint8_t* to, uint64_t size) {
    uint64_t packed;
    if (stored_size < sizeof packed) return false;
    memcpy(&packed, stored, sizeof packed);
    if (packed > stored_size - sizeof packed) return false;
    uLongf length = size;
    return uncompress(to, &length, stored + sizeof packed, packed) == Z_OK && length == size;
}

/* True if a plain grid begins with the number that all do, and with the size that the segment states. */
static bool begins_grid(const ty_nanovdb_file* file, const ty_nanovdb_grid* grid) {
    enum { HEAD = 40, OFFSET_GRID_SIZE = 32 };
    uint8_t head[HEAD];
    uint64_t at = 0, size;
    if (!move_to(file, &at, grid->at) || !read_bytes(file, &at, head, sizeof head)) return false;
    memcpy(&size, head + OFFSET_GRID_SIZE, sizeof size);
    return memcmp(head, "NanoVDB", 7) == 0 && size == grid->size;
}

static bool sizes_agree(const ty_nanovdb_file* file, const ty_nanovdb_grid* grid) {
    enum { RATIO_MAX = 1032 }; /* maximum compression ratio of deflate */
    if (grid->codec == TY_NANOVDB_ZIP) return grid->size / RATIO_MAX <= grid->stored_size;
    return grid->size == grid->stored_size && begins_grid(file, grid);
}

ty_result ty_nanovdb_load(const ty_nanovdb_file* file, const ty_nanovdb_grid* grid, uint8_t** bytes) {
    const bool zip = grid->codec == TY_NANOVDB_ZIP;
    if (!sizes_agree(file, grid)) return ty_nanovdb_damaged(file, grid->name);
    uint64_t at = 0;
    uint8_t* stored = ty_alloc_array(file->context, grid->stored_size, 1, false);
    uint8_t* plain = zip ? ty_alloc_array(file->context, grid->size, 1, false) : stored;
    ty_result result = stored == NULL || plain == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK && (!move_to(file, &at, grid->at) || !read_bytes(file, &at, stored, grid->stored_size) ||
                            (zip && !unpack(stored, grid->stored_size, plain, grid->size))))
        result = ty_nanovdb_damaged(file, grid->name);
    if (zip || result != TY_OK) ty_free_array(file->context, stored, grid->stored_size, 1);
    if (zip && result != TY_OK) ty_free_array(file->context, plain, grid->size, 1);
    if (result == TY_OK) *bytes = plain;
    return result;
}

/* Inflates a zip block of a mapping into another, of which neither stays in memory. */
static bool unpack_mapped(const ty_mapping* from, uint64_t at, uint64_t stored_size, const ty_mapping* to) {
    enum { AT_ONCE = 1 << 22 };
    uint64_t packed = 0;
    if (stored_size >= sizeof packed) memcpy(&packed, from->bytes + at, sizeof packed);
    if (packed == 0 || packed > stored_size - sizeof packed) return false;
    z_stream z = {.next_in = from->bytes + at + sizeof packed};
    size_t read = 0, made = 0;
    int status = inflateInit(&z);
    if (status != Z_OK) return false;
    while (status == Z_OK && made < to->size) {
        z.avail_in = packed - read < AT_ONCE ? (uInt)(packed - read) : (uInt)AT_ONCE;
        z.avail_out = to->size - made < AT_ONCE ? (uInt)(to->size - made) : (uInt)AT_ONCE;
        z.next_out = to->bytes + made;
        const uint8_t *in = z.next_in, *out = z.next_out;
        status = inflate(&z, Z_NO_FLUSH);
        ty_mapping_unload(from, (size_t)(in - from->bytes), (size_t)(z.next_in - from->bytes));
        ty_mapping_unload(to, (size_t)(out - to->bytes), (size_t)(z.next_out - to->bytes));
        read += (size_t)(z.next_in - in);
        made += (size_t)(z.next_out - out);
    }
    const bool whole = made == to->size && (status == Z_OK || status == Z_STREAM_END);
    inflateEnd(&z);
    return whole;
}

ty_result ty_nanovdb_map(const ty_nanovdb_file* file, const ty_nanovdb_grid* grid, ty_mapping** mapping,
                         const uint8_t** bytes) {
    ty_mapping *stored = NULL, *plain = NULL;
    if (!sizes_agree(file, grid)) return ty_nanovdb_damaged(file, grid->name);
    ty_result result = ty_mapping_open(file->context, file->path, &stored);
    if (result == TY_OK && (stored->size < grid->at || stored->size - grid->at < grid->stored_size || grid->size == 0))
        result = ty_nanovdb_damaged(file, grid->name);
    if (result == TY_OK && grid->codec != TY_NANOVDB_ZIP) {
        *mapping = stored;
        *bytes = stored->bytes + grid->at;
        return TY_OK;
    }
    if (result == TY_OK) result = ty_mapping_create(file->context, (size_t)grid->size, &plain);
    if (result == TY_OK && !unpack_mapped(stored, grid->at, grid->stored_size, plain))
        result = ty_nanovdb_damaged(file, grid->name);
    ty_mapping_close(stored);
    if (result == TY_OK) {
        *mapping = plain;
        *bytes = plain->bytes;
    } else {
        ty_mapping_close(plain);
    }
    return result;
}
