/* Writing NRRD. */

#include "base/context.h"
#include "grid/grid.h"
#include "io/file.h"
#include "io/schema_text.h"

#include <tyndall/io.h>
#include <zlib.h>

static void append_vector(char* text, size_t size, const double* column) {
    for (int r = 0; r < 3; ++r) {
        ty_append(text, size, r == 0 ? "(" : ",");
        ty_append_number(text, size, column[4 * r]);
    }
    ty_append(text, size, ")");
}

static void write_header(ty_output* output, const ty_grid_info* info, bool gzip) {
    char directions[512] = "", origin[160] = "";
    for (int a = 0; a < 3; ++a) {
        if (a > 0) ty_append(directions, sizeof directions, " ");
        append_vector(directions, sizeof directions, info->index_to_local.m + a);
    }
    append_vector(origin, sizeof origin, info->index_to_local.m + 3);
    char text[1024];
    const int length =
        snprintf(text, sizeof text,
                 "NRRD0004\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: %d %d %d\nspace directions: %s\n"
                 "kinds: domain domain domain\nendian: %s\nencoding: %s\nspace origin: %s\n\n",
                 info->size[0], info->size[1], info->size[2], directions,
                 __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__ ? "big" : "little", gzip ? "gzip" : "raw", origin);
    ty_output_write(output, text, (size_t)length);
}

/* Output of the voxels: the file itself, or deflate before it. */
typedef struct sink {
    ty_output* output;
    bool gzip;
    z_stream z;
    uint8_t packed[1 << 16];
} sink;

static bool put(sink* s, const void* bytes, size_t size, bool last) {
    if (!s->gzip) return ty_output_write(s->output, bytes, size);
    s->z.next_in = (Bytef*)(uintptr_t)bytes;
    s->z.avail_in = (uInt)size;
    do {
        s->z.next_out = s->packed;
        s->z.avail_out = sizeof s->packed;
        deflate(&s->z, last ? Z_FINISH : Z_NO_FLUSH);
        const size_t made = sizeof s->packed - s->z.avail_out;
        if (!ty_output_write(s->output, s->packed, made)) return false;
    } while (s->z.avail_out == 0);
    return true;
}

static ty_result write_voxels(ty_context* context, const ty_grid* grid, const ty_grid_info* info, sink* s) {
    const size_t nx = (size_t)info->size[0];
    float* row = ty_alloc_array(context, nx, sizeof *row, false);
    if (row == NULL) return TY_ERROR_MEMORY;
    bool good = true;
    for (int32_t k = 0; k < info->size[2] && good; ++k)
        for (int32_t j = 0; j < info->size[1] && good; ++j) {
            for (int32_t i = 0; i < info->size[0]; ++i) row[i] = ty_grid_voxel(grid, i, j, k);
            good = put(s, row, nx * sizeof *row, k == info->size[2] - 1 && j == info->size[1] - 1);
        }
    ty_free_array(context, row, nx, sizeof *row);
    return TY_OK; /* the commit reports write errors */
}

static ty_result write_content(ty_context* context, const ty_grid* grid, bool gzip, ty_output* output) {
    enum { LEVEL = 6, WINDOW_GZIP = 15 + 16, MEMORY = 8 };
    const ty_grid_info info = ty_grid_get_info(grid);
    sink* s = ty_alloc_array(context, 1, sizeof *s, true);
    if (s == NULL) return TY_ERROR_MEMORY;
    s->output = output;
    s->gzip = gzip;
    ty_result result = TY_OK;
    if (gzip && deflateInit2(&s->z, LEVEL, Z_DEFLATED, WINDOW_GZIP, MEMORY, Z_DEFAULT_STRATEGY) != Z_OK)
        result = ty_fail(context, TY_ERROR_MEMORY, "not enough memory to write %s", output->path);
    write_header(output, &info, gzip);
    if (result == TY_OK) result = write_voxels(context, grid, &info, s);
    if (gzip) deflateEnd(&s->z);
    ty_free_array(context, s, 1, sizeof *s);
    return result;
}

ty_result ty_nrrd_write(ty_context* context, const ty_grid* grid, ty_nrrd_codec codec, const char* path) {
    if (grid == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_nrrd_write: the grid is NULL");
    ty_output output;
    ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    result = write_content(context, grid, codec == TY_NRRD_CODEC_GZIP, &output);
    if (result == TY_OK) return ty_output_commit(context, &output);
    ty_output_discard(context, &output);
    return result;
}
