/* Voxels, packed or not, into an output. */
#include "io/volumes/gzip_output.h"

#include "base/context.h"

ty_gzip_output* ty_gzip_begin(ty_context* context, ty_output* output, bool gzip) {
    enum { LEVEL = 6, WINDOW_GZIP = 15 + 16, MEMORY = 8 };
    ty_gzip_output* g = ty_alloc_array(context, 1, sizeof *g, true);
    if (g == NULL) return NULL;
    g->output = output;
    g->gzip = gzip;
    if (!gzip || deflateInit2(&g->z, LEVEL, Z_DEFLATED, WINDOW_GZIP, MEMORY, Z_DEFAULT_STRATEGY) == Z_OK) return g;
    ty_fail(context, TY_ERROR_MEMORY, "not enough memory to write %s", output->path);
    ty_free_array(context, g, 1, sizeof *g);
    return NULL;
}

static bool pack(ty_gzip_output* g, const void* bytes, size_t size, int flush) {
    g->z.next_in = (Bytef*)(uintptr_t)bytes;
    g->z.avail_in = (uInt)size;
    do {
        g->z.next_out = g->packed;
        g->z.avail_out = sizeof g->packed;
        deflate(&g->z, flush);
        const size_t made = sizeof g->packed - g->z.avail_out;
        if (!ty_output_write(g->output, g->packed, made)) return false;
    } while (g->z.avail_out == 0);
    return true;
}

bool ty_gzip_put(ty_gzip_output* g, const void* bytes, size_t size) {
    return g->gzip ? pack(g, bytes, size, Z_NO_FLUSH) : ty_output_write(g->output, bytes, size);
}

ty_result ty_gzip_put_voxels(ty_context* context, ty_gzip_output* g, const ty_grid* grid) {
    const ty_grid_info info = ty_grid_get_info(grid);
    const size_t nx = (size_t)info.size[0];
    float* row = ty_alloc_array(context, nx, sizeof *row, false);
    if (row == NULL) return TY_ERROR_MEMORY;
    bool good = true;
    for (int32_t k = 0; k < info.size[2] && good; ++k)
        for (int32_t j = 0; j < info.size[1] && good; ++j) {
            for (int32_t i = 0; i < info.size[0]; ++i) row[i] = ty_grid_voxel(grid, i, j, k);
            good = ty_gzip_put(g, row, nx * sizeof *row);
        }
    ty_free_array(context, row, nx, sizeof *row);
    return TY_OK; /* the commit reports write errors */
}

void ty_gzip_end(ty_context* context, ty_gzip_output* g) {
    if (g == NULL) return;
    if (g->gzip) {
        pack(g, NULL, 0, Z_FINISH);
        deflateEnd(&g->z);
    }
    ty_free_array(context, g, 1, sizeof *g);
}
