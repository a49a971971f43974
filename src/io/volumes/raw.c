/* Raw volumes without a header. */
#include "io/volumes/sample_file.h"
#include "io/volumes/volume_file.h"

#include "base/context.h"
#include "io/file.h"

#include <string.h>

static ty_result check_spacing(ty_context* context, const ty_volume_def* def, ty_grid_def* grid) {
    int given = 0;
    for (int a = 0; a < 3; ++a) {
        const double spacing = def->raw_spacing[a];
        if (!(spacing >= 0 && spacing <= 1e15))
            return ty_fail(context, TY_ERROR_ARGUMENT, "raw_spacing along %c is %g, outside [0, 1e15]", "xyz"[a],
                           spacing);
        given += spacing > 0;
        grid->index_to_local.m[5 * a] = spacing > 0 ? spacing : 1;
    }
    if (given == 1 || given == 2)
        return ty_fail(context, TY_ERROR_ARGUMENT, "raw_spacing is 0 along some axes but not all");
    grid->placed = given == 3;
    return TY_OK;
}

/* Offset of the samples in the file. */
static ty_result find_start(ty_context* context, const char* path, const ty_volume_def* def, size_t needed,
                            size_t* start) {
    FILE* stream = NULL;
    uint64_t size = 0;
    const ty_result result = ty_open_file(context, path, &stream, &size);
    if (result != TY_OK) return result;
    fclose(stream);
    const uint64_t extra = size > needed ? size - needed : 0;
    *start = def->raw_offset < 0 ? (size_t)extra : (size_t)def->raw_offset;
    if (size >= needed && *start == extra) return TY_OK;
    return ty_fail(context, TY_ERROR_INPUT, "%s: %llu bytes; %d x %d x %d voxels of %s after %zu bytes are %zu", path,
                   (unsigned long long)size, def->raw_size[0], def->raw_size[1], def->raw_size[2], def->raw_type,
                   *start, needed + *start);
}

ty_result ty_raw_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out) {
    const ty_sample_type type = ty_sample_type_of(def->raw_type);
    if (type == TY_SAMPLE_TYPES)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "raw_type is \"%s\", not int8, uint8 ... uint64, half, float or double", def->raw_type);
    if (def->raw_offset < -1)
        return ty_fail(context, TY_ERROR_ARGUMENT, "raw_offset is %lld, below -1", (long long)def->raw_offset);
    const ty_grid_plan plan = ty_volume_plan(def);
    size_t voxels = 0, start = 0;
    ty_grid_def grid = ty_default_grid_def();
    memcpy(grid.size, def->raw_size, sizeof grid.size);
    ty_result result = check_spacing(context, def, &grid);
    if (result == TY_OK)
        result = ty_check_volume_storage(context, path, ty_plan_limits(&plan), false,
                                         (const int64_t[]){grid.size[0], grid.size[1], grid.size[2]}, &voxels);
    if (result == TY_OK) result = ty_check_component(context, path, NULL, def->component, 1);
    const size_t needed = result == TY_OK ? voxels * ty_sample_size(type) : 0;
    if (result == TY_OK) result = find_start(context, path, def, needed, &start);
    ty_sample_file file;
    if (result == TY_OK) result = ty_sample_file_open(context, path, start, &file);
    if (result != TY_OK) return result;
    const ty_samples samples = {.read = ty_sample_file_read,
                                .user = &file,
                                .type = type,
                                .big_endian = def->raw_big_endian,
                                .step = 1,
                                .plan = plan};
    result = ty_samples_make_grid(context, &samples, &grid, out);
    ty_sample_file_close(&file);
    return result;
}
