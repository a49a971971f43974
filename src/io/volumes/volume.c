/* Volumes of any format: choice of the reader, file sequences, common validation. */
#include "io/volumes/volume_file.h"

#include "base/context.h"
#include "grid/grid.h"
#include "io/file.h"
#include "io/volumes/netcdf/netcdf.h"
#include "io/volumes/vtk/vtk.h"

#include <stdarg.h>
#include <string.h>
#include <strings.h>

enum { PATH_SIZE = 4096 };

/* Blocks of paged grids are numbered by 32 bits. */
static const double voxels_max = 4e9, sparse_voxels_max = 3.2e10, paged_voxels_max = 2e12;

void ty_init_volume_def(void* def, size_t bytes) {
    const ty_volume_def own = {.grid = "density", .raw_type = "uint8", .series = "", .meters_per_unit = 1};
    ty_init_def(def, bytes, &own, sizeof own);
}

ty_grid_plan ty_volume_plan(const ty_volume_def* def) {
    ty_grid_plan plan = {.storage = def->storage == TY_GRID_PAGED ? TY_GRID_PAGED : TY_GRID_AUTO, .part = def->in_part};
    memcpy(plan.first, def->part_first, sizeof plan.first);
    memcpy(plan.end, def->part_end, sizeof plan.end);
    return plan;
}

ty_grid_storage ty_plan_limits(const ty_grid_plan* plan) {
    return plan->part ? TY_GRID_PAGED : plan->storage;
}

static ty_result check_size(ty_context* context, const char* path, const char* kind, double limit,
                            const int64_t sides[3], size_t* voxels) {
    double product = 1;
    bool fits = true;
    for (int a = 0; a < 3; ++a) {
        product *= (double)sides[a];
        fits = fits && sides[a] >= 1 && sides[a] <= TY_GRID_SIDE_MAX;
    }
    if (!fits || product > limit)
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s: spans %lld x %lld x %lld voxels; %s grids have 1 to %d a side and up to %.0f in all", path,
                       (long long)sides[0], (long long)sides[1], (long long)sides[2], kind, TY_GRID_SIDE_MAX, limit);
    *voxels = (size_t)product;
    return TY_OK;
}

ty_result ty_check_volume_size(ty_context* context, const char* path, const int64_t sides[3], size_t* voxels) {
    return check_size(context, path, "dense", voxels_max, sides, voxels);
}

ty_result ty_check_volume_storage(ty_context* context, const char* path, ty_grid_storage storage, bool in_tree,
                                  const int64_t sides[3], size_t* voxels) {
    if (storage == TY_GRID_PAGED) return check_size(context, path, "paged", paged_voxels_max, sides, voxels);
    return check_size(context, path, in_tree ? "sparse" : "dense", in_tree ? sparse_voxels_max : voxels_max, sides,
                      voxels);
}

ty_result ty_check_component(ty_context* context, const char* path, const char* name, int32_t component,
                             int32_t components) {
    if (component < components && (component >= 0 || components == 1)) return TY_OK;
    const char *quote = name != NULL ? "\"" : "", *what = name != NULL ? ": grid " : "";
    if (name == NULL) name = "";
    if (component < 0)
        return ty_fail(context, TY_ERROR_INPUT, "%s%s%s%s%s has %d values per voxel (as vec3s has), not one", path,
                       what, quote, name, quote, components);
    return ty_fail(context, TY_ERROR_INPUT, "%s%s%s%s%s has %d value%s per voxel; component %d is not among them", path,
                   what, quote, name, quote, components, components == 1 ? "" : "s", component);
}

ty_result ty_volume_path(ty_context* context, const char* path, int32_t frame, char* out, size_t size) {
    if (path == NULL || out == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_path: path or out is NULL");
    if (frame < 0) return ty_fail(context, TY_ERROR_ARGUMENT, "frame is %d, below 0", frame);
    const char* slash = strrchr(path, '/'); /* #s in folders are literal */
    const size_t name = slash != NULL ? (size_t)(slash + 1 - path) : 0;
    const size_t first = name + strcspn(path + name, "#"), digits = strspn(path + first, "#");
    char number[64] = "";
    if (digits >= sizeof number) return ty_fail(context, TY_ERROR_ARGUMENT, "%s: too many #s", path);
    if (digits > 0) snprintf(number, sizeof number, "%0*d", (int)digits, frame);
    if (strchr(path + first + digits, '#') != NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the #s are in more than one place", path);
    const int length = snprintf(out, size, "%.*s%s%s", (int)first, path, number, path + first + digits);
    if (length < 0 || (size_t)length >= size)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: longer than %zu bytes", path, size);
    return TY_OK;
}

void ty_note(ty_volume_notes* notes, const char* name, const char* format, ...) {
    if (notes->count == TY_VOLUME_NOTES_MAX) return;
    ty_volume_note* note = &notes->items[notes->count++];
    snprintf(note->name, sizeof note->name, "%s", name);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(note->text, sizeof note->text, format, arguments);
    va_end(arguments);
}

bool ty_volume_has_extension(const char* path, const char* extension) {
    const size_t length = strlen(path), size = strlen(extension);
    return length > size && strcasecmp(path + length - size, extension) == 0;
}

/* Formats by the bytes at an offset, and the extensions of files that do not begin so. */
static const struct {
    ty_volume_format format;
    size_t offset, length;
    const char *magic, *extensions[3];
} formats[] = {
    {TY_VOLUME_VDB, 0, 4, " BDV", {".vdb"}},
    {TY_VOLUME_NANOVDB, 0, 7, "NanoVDB", {".nvdb"}},
    {TY_VOLUME_NRRD, 0, 4, "NRRD", {".nrrd", ".nhdr"}},
    {TY_VOLUME_VTK, 0, 5, "<?xml", {".vti", ".vtk"}},
    {TY_VOLUME_VTK, 0, 8, "<VTKFile", {NULL}},
    {TY_VOLUME_VTK, 0, 8, "# vtk Da", {NULL}},
    {TY_VOLUME_NETCDF, 0, 3, "CDF", {".nc", ".cdf"}},
    {TY_VOLUME_NETCDF, 0, 4, "\x89HDF", {NULL}},
    {TY_VOLUME_DICOM, 128, 4, "DICM", {".dcm", ".dicom", ".ima"}},
    {TY_VOLUME_NIFTI, 344, 4, "n+1", {".nii", ".nii.gz", ".hdr.gz"}},
    {TY_VOLUME_NIFTI, 344, 4, "ni1", {NULL}},
    {TY_VOLUME_NIFTI, 4, 4, "n+2", {NULL}},
    {TY_VOLUME_NIFTI, 4, 4, "ni2", {NULL}},
    {TY_VOLUME_TIFF, 0, 4, "II*\0", {".tif", ".tiff"}},
    {TY_VOLUME_TIFF, 0, 4, "MM\0*", {NULL}},
    {TY_VOLUME_TIFF, 0, 4, "II+\0", {NULL}}, /* with offsets of 64 bits */
    {TY_VOLUME_TIFF, 0, 4, "MM\0+", {NULL}},
    {TY_VOLUME_MITSUBA, 0, 3, "VOL", {".vol"}},
    {TY_VOLUME_BRICKS, 0, 8, "TYBRICKS", {".bricks"}},
};
enum { FORMATS = sizeof formats / sizeof formats[0], EXTENSIONS = 3 };

ty_volume_format ty_volume_format_of(const char* path, const uint8_t* head, size_t size) {
    for (int i = 0; i < FORMATS; ++i)
        if (size >= formats[i].offset + formats[i].length &&
            memcmp(head + formats[i].offset, formats[i].magic, formats[i].length) == 0)
            return formats[i].format;
    for (int i = 0; i < FORMATS; ++i)
        for (int e = 0; e < EXTENSIONS && formats[i].extensions[e] != NULL; ++e)
            if (ty_volume_has_extension(path, formats[i].extensions[e])) return formats[i].format;
    return TY_VOLUME_RAW;
}

/* A folder is a DICOM series. */
static ty_result find_format(ty_context* context, const char* path, ty_volume_format* format) {
    *format = TY_VOLUME_DICOM;
    if (ty_is_folder(path)) return TY_OK;
    FILE* stream = NULL;
    uint64_t size = 0;
    const ty_result result = ty_open_file(context, path, &stream, &size);
    if (result != TY_OK) return result;
    uint8_t head[TY_VOLUME_HEAD];
    const size_t got = fread(head, 1, sizeof head, stream);
    fclose(stream);
    *format = ty_volume_format_of(path, head, got);
    return TY_OK;
}

static ty_result check_def(ty_context* context, const ty_volume_def** given, ty_volume_def* own, const void* out) {
    *own = ty_default_volume_def();
    const ty_result result = ty_take_def(context, *given, "ty_default_volume_def", own, sizeof *own);
    const ty_volume_def* def = *given = own;
    if (result != TY_OK) return result;
    if (out == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: out is NULL");
    if (def->grid == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: grid is NULL");
    if (def->series == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: series is NULL");
    if (def->component < 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: component is %d, below 0", def->component);
    if (!(def->meters_per_unit > 0 && def->meters_per_unit <= 1e6))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: meters_per_unit is %g, outside (0, 1e6]",
                       def->meters_per_unit);
    if (def->storage < TY_GRID_AUTO || def->storage > TY_GRID_PAGED)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: storage is %d, not a ty_grid_storage",
                       (int)def->storage);
    if (def->in_part && def->storage == TY_GRID_DENSE)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: a part of a grid is not stored dense");
    return TY_OK;
}

/* Raw files need a size, which also marks a file as raw. */
static ty_result check_raw(ty_context* context, const char* path, const ty_volume_def* def) {
    if (def->raw_size[0] > 0 && def->raw_size[1] > 0 && def->raw_size[2] > 0) return TY_OK;
    return ty_fail(context, TY_ERROR_INPUT, "%s: of no format that can be read; a raw volume needs its size (raw_size)",
                   path);
}

/* File of a call, with the frame number, and its format. `out` is only checked for NULL. */
static ty_result find_file(ty_context* context, const char* path, const ty_volume_def** given, ty_volume_def* own,
                           const void* out, char file[PATH_SIZE], ty_volume_format* format) {
    ty_result result = check_def(context, given, own, out);
    if (result == TY_OK) result = ty_volume_path(context, path, own->frame, file, PATH_SIZE);
    return result == TY_OK ? find_format(context, file, format) : result;
}

static ty_result read_format(ty_context* context, ty_volume_format format, const char* file, const ty_volume_def* def,
                             double* radius, ty_grid** out) {
    const ty_grid_plan plan = ty_volume_plan(def);
    switch (format) {
    case TY_VOLUME_VDB: return ty_vdb_read_component(context, file, def->grid, def->component, &plan, out);
    case TY_VOLUME_NANOVDB: return ty_nanovdb_read(context, file, def->grid, def->component, &plan, out);
    case TY_VOLUME_NRRD: return ty_nrrd_read(context, file, def->component, &plan, out);
    case TY_VOLUME_VTK: return ty_vtk_read(context, file, def, out);
    case TY_VOLUME_NETCDF: return ty_netcdf_read(context, file, def, radius, out);
    case TY_VOLUME_DICOM: return ty_dicom_read(context, file, def->series, def->component, &plan, out);
    case TY_VOLUME_NIFTI: return ty_nifti_read(context, file, def->component, &plan, out);
    case TY_VOLUME_TIFF: return ty_tiff_read(context, file, def->component, &plan, out);
    case TY_VOLUME_MITSUBA: return ty_mitsuba_read(context, file, def->component, &plan, out);
    case TY_VOLUME_BRICKS: return ty_bricks_read(context, file, out);
    case TY_VOLUME_RAW: break;
    }
    const ty_result result = check_raw(context, file, def);
    return result == TY_OK ? ty_raw_read(context, file, def, out) : result;
}

/* The part of a grid that its reader made as a whole: a dense one, or a file of bricks. */
static ty_result keep_part(ty_context* context, const ty_volume_def* def, ty_grid** grid) {
    const ty_grid_plan plan = ty_volume_plan(def);
    ty_grid* part = NULL;
    if ((*grid)->blocks.table != NULL && !(*grid)->blocks.maps_tables) return TY_OK;
    const ty_result result = ty_grid_keep_part(context, *grid, &plan, &part);
    ty_grid_release(*grid);
    *grid = part;
    return result;
}

ty_result ty_volume_read_droplets(ty_context* context, const char* path, const ty_volume_def* def, double* radius,
                                  ty_grid** out) {
    char file[PATH_SIZE];
    ty_volume_format format = TY_VOLUME_RAW;
    ty_volume_def own;
    ty_grid* grid = NULL;
    ty_result result = find_file(context, path, &def, &own, out, file, &format);
    if (result == TY_OK) result = read_format(context, format, file, def, radius, &grid);
    if (result == TY_OK && def->in_part) result = keep_part(context, def, &grid);
    if (result != TY_OK) return result;
    result = ty_grid_store(context, grid, def->storage, out);
    ty_grid_release(grid);
    return result;
}

ty_result ty_volume_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out) {
    double radius = 0;
    return ty_volume_read_droplets(context, path, def, &radius, out);
}

ty_result ty_volume_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                         int32_t* count) {
    ty_volume_format format = TY_VOLUME_RAW;
    if (count == NULL || capacity < 0 || (entries == NULL && capacity > 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_list: entries or count is NULL, or capacity negative");
    const ty_result result = find_format(context, path, &format);
    if (result != TY_OK) return result;
    if (format == TY_VOLUME_VTK) return ty_vtk_list(context, path, entries, capacity, count);
    if (format == TY_VOLUME_NETCDF) return ty_netcdf_list(context, path, entries, capacity, count);
    return ty_vdb_list(context, path, entries, capacity, count);
}

ty_result ty_volume_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out) {
    char file[PATH_SIZE];
    ty_volume_format format = TY_VOLUME_RAW;
    ty_volume_def own;
    ty_result result = find_file(context, path, &def, &own, out, file, &format);
    if (result != TY_OK) return result;
    switch (format) {
    case TY_VOLUME_VDB: return ty_vdb_components(context, file, def->grid, out);
    case TY_VOLUME_NANOVDB: return ty_nanovdb_components(context, file, def->grid, out);
    case TY_VOLUME_NRRD: return ty_nrrd_components(context, file, out);
    case TY_VOLUME_VTK: return ty_vtk_components(context, file, def, out);
    case TY_VOLUME_NETCDF: return ty_netcdf_components(context, file, def, out);
    case TY_VOLUME_BRICKS:
    case TY_VOLUME_DICOM: *out = 1; return TY_OK;
    case TY_VOLUME_NIFTI: return ty_nifti_components(context, file, out);
    case TY_VOLUME_TIFF: return ty_tiff_components(context, file, out);
    case TY_VOLUME_MITSUBA: return ty_mitsuba_components(context, file, out);
    case TY_VOLUME_RAW: break;
    }
    result = check_raw(context, file, def);
    if (result == TY_OK) *out = 1;
    return result;
}

void ty_volume_describe(ty_context* context, const char* path, const ty_volume_def* def, ty_volume_notes* notes) {
    char file[PATH_SIZE];
    ty_volume_format format = TY_VOLUME_RAW;
    ty_volume_def own;
    *notes = (ty_volume_notes){0};
    if (find_file(context, path, &def, &own, notes, file, &format) != TY_OK) return;
    switch (format) {
    case TY_VOLUME_DICOM: ty_dicom_describe(context, file, def->series, notes); break;
    case TY_VOLUME_NIFTI: ty_nifti_describe(context, file, notes); break;
    case TY_VOLUME_TIFF: ty_tiff_describe(context, file, notes); break;
    case TY_VOLUME_MITSUBA: ty_mitsuba_describe(context, file, notes); break;
    default: break;
    }
}
