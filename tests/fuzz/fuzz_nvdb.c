/* NanoVDB files: listing, then reading every component of every grid listed. An input that begins with N is a file;
 * any other is a small plain file of a grid, changed: a type for the grid, then patches of a 32-bit offset, counted
 * from the start or from a place of interest, and a 32-bit word each. Plain files are too large to be found by chance.
 */
#include "fuzz_target.h"

#include <tyndall/io.h>

#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { PATCH_SIZE = 8, PATCHES_MAX = 64, FILE_TYPE = 48, GRID_START = 200, GRID_TYPE = GRID_START + 636 };

static void read_all(ty_context* context, const char* path) {
    ty_vdb_entry entries[4];
    int32_t count = 0;
    if (ty_vdb_list(context, path, entries, 4, &count) != TY_OK) return;
    for (int32_t i = 0; i < count && i < 4; ++i) {
        ty_volume_def def = ty_default_volume_def();
        int32_t components = 0;
        def.grid = entries[i].name;
        if (ty_volume_components(context, path, &def, &components) != TY_OK) continue;
        for (def.component = 0; def.component < components; ++def.component) {
            ty_grid* grid = NULL;
            if (ty_volume_read(context, path, &def, &grid) == TY_OK) ty_grid_release(grid);
        }
    }
}

/* A plain file of 20^3 voxels, made once. */
static const uint8_t* plain_file(size_t* size) {
    static uint8_t bytes[1 << 20];
    static size_t length;
    *size = length;
    if (length > 0) return bytes;
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    float values[20 * 20 * 20];
    for (int i = 0; i < 20 * 20 * 20; ++i) values[i] = i % 3 == 0 ? 0 : (float)i;
    ty_grid_def def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) def.size[a] = 20;
    def.values = values;
    ty_grid* grid = NULL;
    char path[64];
    snprintf(path, sizeof path, "/tmp/fuzz_nvdb.%ld", (long)getpid());
    if (ty_grid_create(context, &def, &grid) != TY_OK ||
        ty_nanovdb_write(context, grid, "density", "none", path) != TY_OK)
        abort();
    ty_grid_release(grid);
    fuzz_finish(context, &used);
    FILE* stream = fopen(path, "rb");
    if (stream == NULL) abort();
    length = fread(bytes, 1, sizeof bytes, stream);
    fclose(stream);
    unlink(path);
    *size = length;
    return bytes;
}

static void write_patched(int file, const uint8_t* bytes, size_t size) {
    static const uint32_t places[] = {0, GRID_START, GRID_START + 672, GRID_START + 736, GRID_START + 832};
    size_t length = 0;
    const uint8_t* plain = plain_file(&length);
    const uint32_t type = size > 0 ? bytes[0] % 20u : 1;
    if (write(file, plain, length) != (ssize_t)length || pwrite(file, &type, sizeof type, FILE_TYPE) < 0 ||
        pwrite(file, &type, sizeof type, GRID_TYPE) < 0)
        abort();
    for (size_t i = 0; i < PATCHES_MAX && 1 + PATCH_SIZE * (i + 1) <= size; ++i) {
        uint32_t offset;
        memcpy(&offset, bytes + 1 + PATCH_SIZE * i, sizeof offset);
        const uint32_t place = places[(offset >> 24) % (sizeof places / sizeof places[0])];
        const off_t at = (off_t)((place + (offset & 0xffffff)) % (length - sizeof offset));
        if (pwrite(file, bytes + 1 + PATCH_SIZE * i + sizeof offset, sizeof offset, at) < 0) abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    const int file = memfd_create("fuzz.nvdb", MFD_CLOEXEC);
    if (file < 0) abort();
    if (size > 0 && bytes[0] != 'N')
        write_patched(file, bytes, size);
    else if (write(file, bytes, size) != (ssize_t)size)
        abort();
    return fuzz_read_file(file, read_all);
}
