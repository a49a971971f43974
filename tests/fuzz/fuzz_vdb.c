/* OpenVDB files: listing, then reading every grid listed. The bytes go through a file in memory. */
#include "fuzz_target.h"

#include <tyndall/io.h>

static void read_all(ty_context* context, const char* path) {
    ty_vdb_entry entries[4];
    int32_t count = 0;
    if (ty_vdb_list(context, path, entries, 4, &count) != TY_OK) return;
    for (int32_t i = 0; i < count && i < 4; ++i) {
        ty_grid* grid = NULL;
        if (ty_vdb_read(context, path, entries[i].name, &grid) == TY_OK) ty_grid_release(grid);
        ty_volume_def def = ty_default_volume_def();
        def.grid = entries[i].name;
        def.component = 2;
        if (ty_volume_read(context, path, &def, &grid) == TY_OK) ty_grid_release(grid);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_read_bytes(bytes, size, read_all);
}
