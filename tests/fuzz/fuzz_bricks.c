/* Files of bricks, whose tables and blocks are used where they lie in the file: every block is looked up. */
#include "fuzz_target.h"

#include "io/volumes/volume_file.h"

static void read_all(ty_context* context, const char* path) {
    ty_grid* grid = NULL;
    if (ty_bricks_read(context, path, &grid) != TY_OK) return;
    const ty_grid_info info = ty_grid_get_info(grid);
    float sum = 0;
    for (int32_t k = 0; k < info.size[2]; k += 8)
        for (int32_t j = 0; j < info.size[1]; j += 8)
            for (int32_t i = 0; i < info.size[0]; i += 8) sum += ty_grid_voxel(grid, i, j, k);
    if (sum == 12345.0f) abort(); /* the sum is used */
    ty_grid_release(grid);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_read_bytes(bytes, size, read_all);
}
