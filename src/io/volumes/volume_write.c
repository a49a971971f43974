/* Writing volumes of any format: choice of the writer, common checks. */
#include "io/volumes/nifti/nifti.h"
#include "io/volumes/vdb.h"
#include "io/volumes/volume_file.h"
#include "io/volumes/vtk/vtk.h"

#include "base/context.h"

#include <string.h>

static bool same_lattice(const ty_grid* a, const ty_grid* b) {
    const ty_grid_info x = ty_grid_get_info(a), y = ty_grid_get_info(b);
    return memcmp(x.size, y.size, sizeof x.size) == 0 &&
           memcmp(x.index_to_local.m, y.index_to_local.m, sizeof x.index_to_local.m) == 0;
}

static ty_result check_fields(ty_context* context, const ty_volume_field* fields, int32_t count) {
    if (fields == NULL || count < 1) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_write: there are no fields");
    for (int32_t i = 0; i < count; ++i) {
        const ty_volume_field* field = &fields[i];
        if (field->name == NULL || field->name[0] == '\0' || strlen(field->name) >= TY_VDB_NAME_SIZE)
            return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_write: a name is not 1..%d characters",
                           (int)TY_VDB_NAME_SIZE - 1);
        if (field->components != 1 && field->components != 3)
            return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_write: \"%s\" has %d components, not 1 or 3",
                           field->name, field->components);
        for (int32_t c = 0; c < field->components; ++c)
            if (field->grids[c] == NULL || !same_lattice(field->grids[c], field->grids[0]) ||
                ty_grid_get_info(field->grids[c]).type != ty_grid_get_info(field->grids[0]).type)
                return ty_fail(context, TY_ERROR_ARGUMENT,
                               "ty_volume_write: the components of \"%s\" differ in size, placement or type",
                               field->name);
    }
    return TY_OK;
}

static ty_result wrong_codec(ty_context* context, const char* path, const char* codec) {
    return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the format has no codec \"%s\"", path, codec);
}

/* Ends an output by the result of what was written to it. */
static ty_result finish(ty_context* context, ty_output* output, ty_result result) {
    if (result == TY_OK) return ty_output_commit(context, output);
    ty_output_discard(context, output);
    return result;
}

static ty_result write_vdb(ty_context* context, const ty_volume_field* fields, int32_t count, const char* codec,
                           const char* path) {
    uint32_t compression = 0;
    ty_output output;
    if (!ty_vdb_find_codec(context, codec != NULL ? codec : "zip", &compression)) return TY_ERROR_ARGUMENT;
    const ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    return finish(context, &output, ty_vdb_write_file(context, fields, count, compression, &output));
}

static ty_result write_vti(ty_context* context, const ty_volume_field* fields, int32_t count, const char* codec,
                           const char* path) {
    ty_output output;
    const bool none = codec != NULL && strcmp(codec, "none") == 0;
    if (codec != NULL && !none && strcmp(codec, "zip") != 0) return wrong_codec(context, path, codec);
    for (int32_t i = 1; i < count; ++i)
        if (!same_lattice(fields[i].grids[0], fields[0].grids[0]))
            return ty_fail(context, TY_ERROR_ARGUMENT,
                           "%s: \"%s\" and \"%s\" differ in size or placement, which a .vti file has one of", path,
                           fields[0].name, fields[i].name);
    const ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    return finish(context, &output, ty_vti_write_file(context, fields, count, !none, &output));
}

static ty_result write_nifti(ty_context* context, const ty_volume_field* fields, int32_t count, const char* codec,
                             const char* path) {
    const bool gzip = ty_volume_has_extension(path, ".gz");
    if (codec != NULL && strcmp(codec, gzip ? "gzip" : "none") != 0) return wrong_codec(context, path, codec);
    if (count > 1) return ty_fail(context, TY_ERROR_ARGUMENT, "%s: one field goes there", path);
    return ty_nifti_write_file(context, fields, gzip, path);
}

ty_result ty_volume_write(ty_context* context, const ty_volume_field* fields, int32_t count, const char* codec,
                          const char* path) {
    const ty_result result = check_fields(context, fields, count);
    if (result != TY_OK) return result;
    if (path == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_write: path is NULL");
    if (ty_volume_has_extension(path, ".vdb")) return write_vdb(context, fields, count, codec, path);
    if (ty_volume_has_extension(path, ".vti")) return write_vti(context, fields, count, codec, path);
    if (ty_volume_has_extension(path, ".nii") || ty_volume_has_extension(path, ".nii.gz"))
        return write_nifti(context, fields, count, codec, path);
    const bool bricks = ty_volume_has_extension(path, ".bricks");
    const bool nanovdb = ty_volume_has_extension(path, ".nvdb"), mitsuba = ty_volume_has_extension(path, ".vol");
    if (!nanovdb && !mitsuba && !bricks && !ty_volume_has_extension(path, ".nrrd"))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "%s: a volume goes to .vdb, .nvdb, .nrrd, .vti, .nii, .nii.gz, .vol or .bricks", path);
    if (count > 1 || fields[0].components > 1)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: one field of one value per voxel goes there", path);
    if (nanovdb) return ty_nanovdb_write(context, fields[0].grids[0], fields[0].name, codec ? codec : "zip", path);
    const bool none = codec != NULL && strcmp(codec, "none") == 0;
    if ((mitsuba || bricks) && codec != NULL && !none) return wrong_codec(context, path, codec);
    if (bricks) return ty_bricks_write(context, fields[0].grids[0], path);
    if (mitsuba) return ty_mitsuba_write(context, fields[0].grids[0], path);
    if (codec != NULL && !none && strcmp(codec, "gzip") != 0) return wrong_codec(context, path, codec);
    return ty_nrrd_write(context, fields[0].grids[0], none ? TY_NRRD_CODEC_RAW : TY_NRRD_CODEC_GZIP, path);
}
