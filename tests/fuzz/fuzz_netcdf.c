/* NetCDF files: listing, then every variable, and each as the water of droplets. The bytes go through a file in memory.
 * The library's own faults, and those of HDF5 below it, would be found, too. */
#include "fuzz_target.h"

#include <tyndall/io.h>

static void read_all(ty_context* context, const char* path) {
    ty_vdb_entry entries[4];
    int32_t count = 0;
    if (ty_volume_list(context, path, entries, 4, &count) != TY_OK) return;
    for (int32_t i = 0; i < count && i < 4; ++i) {
        ty_volume_def def = ty_default_volume_def();
        ty_grid* grid = NULL;
        int32_t times = 1;
        def.grid = entries[i].name;
        if (ty_volume_components(context, path, &def, &times) == TY_OK) def.component = times - 1;
        if (ty_volume_read(context, path, &def, &grid) == TY_OK) ty_grid_release(grid);
        def.effective_radius = "reff";
        def.air_density_value = 1;
        if (ty_volume_read(context, path, &def, &grid) == TY_OK) ty_grid_release(grid);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_read_bytes(bytes, size, read_all);
}
