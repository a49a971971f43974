/* Writing NRRD. */

#include "base/context.h"
#include "grid/grid.h"
#include "io/file.h"
#include "io/schema_text.h"
#include "io/volumes/gzip_output.h"

#include <tyndall/io.h>

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

static ty_result write_content(ty_context* context, const ty_grid* grid, bool gzip, ty_output* output) {
    const ty_grid_info info = ty_grid_get_info(grid);
    ty_gzip_output* g = ty_gzip_begin(context, output, gzip);
    if (g == NULL) return TY_ERROR_MEMORY;
    write_header(output, &info, gzip);
    const ty_result result = ty_gzip_put_voxels(context, g, grid);
    ty_gzip_end(context, g);
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
