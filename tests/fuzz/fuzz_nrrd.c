/* NRRD files with attached data: every component of them. The bytes go through a file in memory. */
#include "fuzz_target.h"

#include <tyndall/io.h>

static void read_all(ty_context* context, const char* path) {
    ty_volume_def def = ty_default_volume_def();
    int32_t components = 0;
    if (ty_volume_components(context, path, &def, &components) != TY_OK) return;
    for (def.component = 0; def.component < components && def.component < 4; ++def.component) {
        ty_grid* grid = NULL;
        if (ty_volume_read(context, path, &def, &grid) == TY_OK) ty_grid_release(grid);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_read_bytes(bytes, size, read_all);
}
