/* Writing NIfTI-1, in the machine's byte order: floats, placed by the sform; three values per voxel as a vector. The
 * offsets of fields are those of nifti1.h. */
#include "base/context.h"
#include "io/file.h"
#include "io/volumes/gzip_output.h"
#include "io/volumes/nifti/nifti.h"

#include <math.h>
#include <string.h>
#include <tyndall/io.h>

enum { DATA = 352, FLOAT32 = 16, VECTOR = 1007, ALIGNED = 2 };

static void set_int(uint8_t* header, size_t at, int32_t value) {
    memcpy(header + at, &value, sizeof value);
}

static void set_short(uint8_t* header, size_t at, int value) {
    const int16_t number = (int16_t)value;
    memcpy(header + at, &number, sizeof number);
}

static void set_float(uint8_t* header, size_t at, double value) {
    const float number = (float)value;
    memcpy(header + at, &number, sizeof number);
}

/* Sides and kinds of values; a vector's components are along the fifth axis. */
static void describe_values(uint8_t* header, const ty_grid_info* info, int32_t components) {
    set_int(header, 0, TY_NIFTI1_BYTES);
    set_short(header, 40, components > 1 ? 5 : 3);
    for (int a = 0; a < 7; ++a) set_short(header, 42 + 2 * (size_t)a, a < 3 ? info->size[a] : a == 4 ? components : 1);
    if (components > 1) set_short(header, 68, VECTOR);
    set_short(header, 70, FLOAT32);
    set_short(header, 72, 32); /* bits */
    set_float(header, 108, DATA);
    set_float(header, 112, 1); /* slope */
    memcpy(header + 344, "n+1", 4);
}

/* The map from indices to places, as three rows, and the lengths of its columns. */
static void describe_place(uint8_t* header, const ty_grid_info* info) {
    const double* m = info->index_to_local.m;
    set_float(header, 76, 1);
    for (size_t a = 0; a < 7; ++a)
        set_float(header, 80 + 4 * a, a < 3 ? sqrt(m[a] * m[a] + m[4 + a] * m[4 + a] + m[8 + a] * m[8 + a]) : 1);
    set_short(header, 254, ALIGNED);
    for (size_t i = 0; i < 12; ++i) set_float(header, 280 + 4 * i, m[i]);
}

static ty_result write_content(ty_context* context, const ty_volume_field* field, bool gzip, ty_output* output) {
    const ty_grid_info info = ty_grid_get_info(field->grids[0]);
    uint8_t header[DATA] = {0};
    describe_values(header, &info, field->components);
    describe_place(header, &info);
    ty_gzip_output* g = ty_gzip_begin(context, output, gzip);
    if (g == NULL) return TY_ERROR_MEMORY;
    ty_gzip_put(g, header, sizeof header);
    ty_result result = TY_OK;
    for (int32_t c = 0; c < field->components && result == TY_OK; ++c)
        result = ty_gzip_put_voxels(context, g, field->grids[c]);
    ty_gzip_end(context, g);
    return result;
}

ty_result ty_nifti_write_file(ty_context* context, const ty_volume_field* field, bool gzip, const char* path) {
    ty_output output;
    ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    result = write_content(context, field, gzip, &output);
    if (result == TY_OK) return ty_output_commit(context, &output);
    ty_output_discard(context, &output);
    return result;
}
