/* Writing Mitsuba's .vol grids: version 3, floats, one value per voxel. */
#include "base/context.h"
#include "grid/grid.h"
#include "io/file.h"

#include <math.h>
#include <string.h>
#include <tyndall/io.h>

enum { HEADER_SIZE = 48 };

static void put_word(uint8_t* to, uint32_t bits) {
    for (int i = 0; i < 4; ++i) to[i] = (uint8_t)(bits >> 8 * i);
}

static void put_float(uint8_t* to, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_word(to, bits);
}

/* The box that the voxels fill, which has no other directions than the axes. */
static ty_result find_box(ty_context* context, const char* path, const ty_grid_info* info, float box[6]) {
    const double* m = info->index_to_local.m;
    bool straight = true;
    for (int r = 0; r < 3; ++r)
        for (int a = 0; a < 3; ++a)
            straight = straight && (a == r ? m[4 * r + a] > 0 : fabs(m[4 * r + a]) <= 1e-6 * fabs(m[5 * r]));
    if (!straight)
        return ty_fail(
            context, TY_ERROR_INPUT,
            "cannot write %s: its voxels would fill a box along the axes, and the grid is turned or reversed", path);
    for (int a = 0; a < 3; ++a) {
        box[a] = (float)(m[4 * a + 3] - m[5 * a] / 2);
        box[3 + a] = (float)(m[4 * a + 3] + m[5 * a] * (info->size[a] - 0.5));
    }
    return TY_OK;
}

static void write_header(ty_output* output, const ty_grid_info* info, const float box[6]) {
    uint8_t header[HEADER_SIZE] = "VOL\3";
    put_word(header + 4, 1); /* floats */
    for (int a = 0; a < 3; ++a) put_word(header + 8 + 4 * a, (uint32_t)info->size[a]);
    put_word(header + 20, 1);
    for (int i = 0; i < 6; ++i) put_float(header + 24 + 4 * i, box[i]);
    ty_output_write(output, header, sizeof header);
}

static ty_result write_voxels(ty_context* context, const ty_grid* grid, const ty_grid_info* info, ty_output* output) {
    const size_t nx = (size_t)info->size[0], bytes = 4;
    uint8_t* row = ty_alloc_array(context, nx, bytes, false);
    if (row == NULL) return TY_ERROR_MEMORY;
    for (int32_t k = 0; k < info->size[2]; ++k)
        for (int32_t j = 0; j < info->size[1] && output->error == 0; ++j) {
            for (int32_t i = 0; i < info->size[0]; ++i)
                put_float(row + bytes * (size_t)i, ty_grid_voxel(grid, i, j, k));
            ty_output_write(output, row, nx * bytes);
        }
    ty_free_array(context, row, nx, bytes);
    return TY_OK; /* the commit reports write errors */
}

ty_result ty_mitsuba_write(ty_context* context, const ty_grid* grid, const char* path) {
    if (grid == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_mitsuba_write: the grid is NULL");
    const ty_grid_info info = ty_grid_get_info(grid);
    float box[6] = {0, 0, 0, 1, 1, 1};
    ty_output output;
    ty_result result = info.placed ? find_box(context, path, &info, box) : TY_OK;
    if (result == TY_OK) result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    write_header(&output, &info, box);
    result = write_voxels(context, grid, &info, &output);
    if (result == TY_OK) return ty_output_commit(context, &output);
    ty_output_discard(context, &output);
    return result;
}
