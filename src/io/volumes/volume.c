/* Volumes of any format: choice of the reader, file sequences, common validation. */
#include "io/volumes/volume_file.h"

#include "base/context.h"
#include "grid/grid.h"
#include "io/file.h"
#include "io/volumes/netcdf.h"
#include "io/volumes/vtk.h"

#include <string.h>
#include <strings.h>

enum { PATH_SIZE = 4096 };

static const double voxels_max = 4e9;

void ty_init_volume_def(void* def, size_t bytes) {
    const ty_volume_def own = {.grid = "density", .raw_type = "uint8", .meters_per_unit = 1};
    ty_init_def(def, bytes, &own, sizeof own);
}

ty_result ty_check_volume_size(ty_context* context, const char* path, const int64_t sides[3], size_t* voxels) {
    double product = 1;
    bool fits = true;
    for (int a = 0; a < 3; ++a) {
        product *= (double)sides[a];
        fits = fits && sides[a] >= 1 && sides[a] <= TY_GRID_SIDE_MAX;
    }
    if (!fits || product > voxels_max)
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s: spans %lld x %lld x %lld voxels; dense grids have 1 to %d a side and up to %.0f in all",
                       path, (long long)sides[0], (long long)sides[1], (long long)sides[2], TY_GRID_SIDE_MAX,
                       voxels_max);
    *voxels = (size_t)product;
    return TY_OK;
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

typedef enum volume_kind { VOLUME_VDB, VOLUME_NANOVDB, VOLUME_NRRD, VOLUME_VTK, VOLUME_NETCDF, VOLUME_RAW } volume_kind;

static bool has_extension(const char* path, const char* extension) {
    const size_t length = strlen(path), size = strlen(extension);
    return length > size && strcasecmp(path + length - size, extension) == 0;
}

/* Detects the format from the first bytes; an unknown file is raw unless its extension says otherwise. */
static ty_result find_kind(ty_context* context, const char* path, volume_kind* kind) {
    static const struct {
        const char *magic, *extensions[2];
        volume_kind kind;
    } known[] = {{" BDV", {".vdb", ".vdb"}, VOLUME_VDB},     {"NanoVDB", {".nvdb", ".nvdb"}, VOLUME_NANOVDB},
                 {"NRRD", {".nrrd", ".nhdr"}, VOLUME_NRRD},  {"<?xml", {".vti", ".vtk"}, VOLUME_VTK},
                 {"<VTKFile", {".vti", ".vtk"}, VOLUME_VTK}, {"# vtk Da", {".vti", ".vtk"}, VOLUME_VTK},
                 {"CDF", {".nc", ".cdf"}, VOLUME_NETCDF},    {"\x89HDF", {".nc", ".cdf"}, VOLUME_NETCDF}};
    enum { KNOWN = sizeof known / sizeof known[0] };
    FILE* stream = NULL;
    uint64_t size = 0;
    const ty_result result = ty_open_file(context, path, &stream, &size);
    if (result != TY_OK) return result;
    char head[8] = "";
    const size_t got = fread(head, 1, sizeof head, stream);
    fclose(stream);
    *kind = VOLUME_RAW;
    for (int i = KNOWN - 1; i >= 0; --i)
        if (has_extension(path, known[i].extensions[0]) || has_extension(path, known[i].extensions[1]))
            *kind = known[i].kind;
    for (int i = 0; i < KNOWN; ++i)
        if (got >= strlen(known[i].magic) && memcmp(head, known[i].magic, strlen(known[i].magic)) == 0)
            *kind = known[i].kind;
    return TY_OK;
}

static ty_result check_def(ty_context* context, const ty_volume_def** given, ty_volume_def* own, const void* out) {
    *own = ty_default_volume_def();
    const ty_result result = ty_take_def(context, *given, "ty_default_volume_def", own, sizeof *own);
    const ty_volume_def* def = *given = own;
    if (result != TY_OK) return result;
    if (out == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: out is NULL");
    if (def->grid == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: grid is NULL");
    if (def->component < 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: component is %d, below 0", def->component);
    if (!(def->meters_per_unit > 0 && def->meters_per_unit <= 1e6))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_read: meters_per_unit is %g, outside (0, 1e6]",
                       def->meters_per_unit);
    return TY_OK;
}

/* Raw files need a size, which also marks a file as raw. */
static ty_result check_raw(ty_context* context, const char* path, const ty_volume_def* def) {
    if (def->raw_size[0] > 0 && def->raw_size[1] > 0 && def->raw_size[2] > 0) return TY_OK;
    return ty_fail(context, TY_ERROR_INPUT,
                   "%s: neither OpenVDB nor NanoVDB nor NRRD, VTK or NetCDF; a raw volume needs its size (raw_size)",
                   path);
}

/* File of a call, with the frame number, and its format. `out` is only checked for NULL. */
static ty_result find_file(ty_context* context, const char* path, const ty_volume_def** given, ty_volume_def* own,
                           const void* out, char file[PATH_SIZE], volume_kind* kind) {
    ty_result result = check_def(context, given, own, out);
    if (result == TY_OK) result = ty_volume_path(context, path, own->frame, file, PATH_SIZE);
    return result == TY_OK ? find_kind(context, file, kind) : result;
}

ty_result ty_volume_read_droplets(ty_context* context, const char* path, const ty_volume_def* def, double* radius,
                                  ty_grid** out) {
    char file[PATH_SIZE];
    volume_kind kind = VOLUME_RAW;
    ty_volume_def own;
    ty_result result = find_file(context, path, &def, &own, out, file, &kind);
    if (result != TY_OK) return result;
    switch (kind) {
    case VOLUME_VDB: return ty_vdb_read_component(context, file, def->grid, def->component, out);
    case VOLUME_NANOVDB: return ty_nanovdb_read(context, file, def->grid, def->component, out);
    case VOLUME_NRRD: return ty_nrrd_read(context, file, def->component, out);
    case VOLUME_VTK: return ty_vtk_read(context, file, def, out);
    case VOLUME_NETCDF: return ty_netcdf_read(context, file, def, radius, out);
    case VOLUME_RAW: break;
    }
    result = check_raw(context, file, def);
    return result == TY_OK ? ty_raw_read(context, file, def, out) : result;
}

ty_result ty_volume_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out) {
    double radius = 0;
    return ty_volume_read_droplets(context, path, def, &radius, out);
}

ty_result ty_volume_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                         int32_t* count) {
    volume_kind kind = VOLUME_RAW;
    if (count == NULL || capacity < 0 || (entries == NULL && capacity > 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_volume_list: entries or count is NULL, or capacity negative");
    const ty_result result = find_kind(context, path, &kind);
    if (result != TY_OK) return result;
    if (kind == VOLUME_VTK) return ty_vtk_list(context, path, entries, capacity, count);
    if (kind == VOLUME_NETCDF) return ty_netcdf_list(context, path, entries, capacity, count);
    return ty_vdb_list(context, path, entries, capacity, count);
}

ty_result ty_volume_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out) {
    char file[PATH_SIZE];
    volume_kind kind = VOLUME_RAW;
    ty_volume_def own;
    ty_result result = find_file(context, path, &def, &own, out, file, &kind);
    if (result != TY_OK) return result;
    switch (kind) {
    case VOLUME_VDB: return ty_vdb_components(context, file, def->grid, out);
    case VOLUME_NANOVDB: return ty_nanovdb_components(context, file, def->grid, out);
    case VOLUME_NRRD: return ty_nrrd_components(context, file, out);
    case VOLUME_VTK: return ty_vtk_components(context, file, def, out);
    case VOLUME_NETCDF: return ty_netcdf_components(context, file, def, out);
    case VOLUME_RAW: break;
    }
    result = check_raw(context, file, def);
    if (result == TY_OK) *out = 1;
    return result;
}
