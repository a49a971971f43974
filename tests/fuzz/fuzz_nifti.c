/* NIfTI files: every component of them, and their notes. The bytes go through a file in memory. */
#include "fuzz_target.h"

#include "io/volumes/volume_file.h"

static void read_all(ty_context* context, const char* path) {
    ty_volume_notes notes = {0};
    const ty_volume_def def = ty_default_volume_def();
    const ty_grid_plan plan = ty_volume_plan(&def);
    int32_t components = 0;
    ty_nifti_describe(context, path, &notes);
    if (ty_nifti_components(context, path, &components) != TY_OK) return;
    for (int32_t component = 0; component < components && component < 4; ++component) {
        ty_grid* grid = NULL;
        if (ty_nifti_read(context, path, component, &plan, &grid) == TY_OK) ty_grid_release(grid);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_read_bytes(bytes, size, read_all);
}
