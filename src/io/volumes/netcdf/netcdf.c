/* Grids of NetCDF variables, and of the extinction of droplets by their liquid water and effective radius. */
#include "io/volumes/netcdf/netcdf.h"

#include "base/context.h"
#include "grid/grid.h"
#include "io/volumes/volume_file.h"

#if TYNDALL_NETCDF

#include "io/volumes/netcdf/calls.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- choice of a variable ---- */

static bool is_volume(const ty_netcdf_file* file, int id, ty_netcdf_variable* variable) {
    int dimensions[NC_MAX_VAR_DIMS], attributes = 0, count = 0;
    nc_type type = NC_NAT;
    char name[NC_MAX_NAME + 1];
    if (file->calls->inq_var(file->id, id, name, &type, &count, dimensions, &attributes) != NC_NOERR || count < 3 ||
        count > TY_NETCDF_DIMENSIONS_MAX)
        return false;
    return ty_netcdf_describe(file, id, variable) == TY_OK && ty_netcdf_find_axes(file, variable);
}

static ty_result count_variables(const ty_netcdf_file* file, int* count) {
    const int status = file->calls->inq_nvars(file->id, count);
    return status == NC_NOERR ? TY_OK : ty_netcdf_fail(file, status);
}

static ty_result missing_variable(const ty_netcdf_file* file, const char* name, int count) {
    char names[512] = "";
    size_t length = 0;
    ty_netcdf_variable variable;
    for (int i = 0; i < count && length < sizeof names; ++i)
        if (is_volume(file, i, &variable))
            length +=
                (size_t)snprintf(names + length, sizeof names - length, "%s%s", length > 0 ? ", " : "", variable.name);
    return ty_fail(file->context, TY_ERROR_INPUT, "%s: no variable \"%s\" of three axes; those that are: %s",
                   file->path, name, length == 0 ? "none" : names);
}

/* The variable of a name; unless the name is binding, else the only volume. */
static ty_result choose_variable(const ty_netcdf_file* file, const ty_volume_def* def, ty_netcdf_variable* out) {
    ty_netcdf_variable variable;
    int id = -1, count = 0, volumes = 0;
    const ty_result result = count_variables(file, &count);
    if (result != TY_OK) return result;
    if (file->calls->inq_varid(file->id, def->grid, &id) == NC_NOERR && is_volume(file, id, out)) return TY_OK;
    for (int i = 0; i < count && !def->exact_grid && id < 0; ++i)
        if (is_volume(file, i, &variable)) {
            ++volumes;
            *out = variable;
        }
    return volumes == 1 ? TY_OK : missing_variable(file, def->grid, count);
}

static int32_t times_of(const ty_netcdf_variable* variable) {
    if (variable->times < 0) return 1;
    const size_t length = variable->lengths[variable->times];
    return length < INT32_MAX ? (int32_t)length : INT32_MAX;
}

/* ---- grids ---- */

static bool wants_droplets(const ty_volume_def* def) {
    return def->effective_radius != NULL || def->droplet_radius > 0;
}

static ty_result read_variable(const ty_netcdf_file* file, const ty_volume_def* def, ty_netcdf_variable* variable,
                               double* radius, ty_grid** out) {
    ty_netcdf_droplets d = {.sum = 0};
    const bool wanted = wants_droplets(def);
    const ty_grid_plan plan = ty_volume_plan(def);
    int64_t sides[3];
    size_t voxels = 0;
    for (int a = 0; a < 3; ++a) sides[a] = (int64_t)variable->axes[a].length;
    ty_result result = ty_check_volume_size(file->context, file->path, sides, &voxels);
    if (result == TY_OK)
        result = ty_check_component(file->context, file->path, variable->name, def->component, times_of(variable));
    if (result == TY_OK) result = ty_netcdf_place(file, variable, def->meters_per_unit);
    if (result == TY_OK && wanted) result = ty_netcdf_open_droplets(file, def, variable, &d);
    if (result == TY_OK) result = ty_netcdf_make_grid(file, variable, def->component, wanted ? &d : NULL, &plan, out);
    ty_netcdf_release_droplets(file, &d);
    if (result != TY_OK || !wanted) return result;
    *radius = d.sum > 0 ? d.sum_radius / d.sum : 0;
    if (d.without_radius > 0)
        ty_log(file->context, TY_LOG_WARNING,
               "%s: %lld voxels of \"%s\" have water and no effective radius; they are empty", file->path,
               (long long)d.without_radius, variable->name);
    return TY_OK;
}

/* ---- entry points ---- */

ty_result ty_netcdf_read(ty_context* context, const char* path, const ty_volume_def* def, double* radius,
                         ty_grid** out) {
    ty_netcdf_file file;
    ty_netcdf_variable variable = {.id = -1};
    ty_result result = ty_netcdf_open(context, path, &file);
    if (result != TY_OK) return result;
    result = choose_variable(&file, def, &variable);
    if (result == TY_OK) result = read_variable(&file, def, &variable, radius, out);
    ty_netcdf_release(&file, &variable);
    ty_netcdf_close(&file);
    return result;
}

ty_result ty_netcdf_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out) {
    ty_netcdf_file file;
    ty_netcdf_variable variable;
    ty_result result = ty_netcdf_open(context, path, &file);
    if (result != TY_OK) return result;
    result = choose_variable(&file, def, &variable);
    if (result == TY_OK) *out = times_of(&variable);
    ty_netcdf_close(&file);
    return result;
}

static const char* type_name(int type) {
    static const char* const names[] = {
        [NC_BYTE] = "int8",     [NC_SHORT] = "int16",  [NC_INT] = "int32",     [NC_FLOAT] = "float",
        [NC_DOUBLE] = "double", [NC_UBYTE] = "uint8",  [NC_USHORT] = "uint16", [NC_UINT] = "uint32",
        [NC_INT64] = "int64",   [NC_UINT64] = "uint64"};
    return type > 0 && type <= NC_UINT64 && names[type] != NULL ? names[type] : "unknown";
}

/* Spacings are means, in m where the coordinates have units; 0 where these place nothing. */
static ty_result fill_entry(const ty_netcdf_file* file, ty_netcdf_variable* variable, ty_vdb_entry* entry) {
    const ty_result result = ty_netcdf_place(file, variable, 1);
    const int32_t times = times_of(variable);
    *entry = (ty_vdb_entry){.active_voxels = 1};
    snprintf(entry->name, sizeof entry->name, "%.127s", variable->name);
    if (times == 1)
        snprintf(entry->type, sizeof entry->type, "%s", type_name(variable->type));
    else
        snprintf(entry->type, sizeof entry->type, "%s[%d]", type_name(variable->type), times);
    for (int a = 0; a < 3; ++a) {
        const ty_netcdf_axis* axis = &variable->axes[a];
        const int64_t length = axis->length < INT32_MAX ? (int64_t)axis->length : INT32_MAX;
        entry->upper[a] = (int32_t)(length - 1);
        entry->active_voxels =
            length > 0 && entry->active_voxels > INT64_MAX / length ? INT64_MAX : entry->active_voxels * length;
        if (axis->placed && result == TY_OK)
            entry->voxel_size[a] = (axis->edges[axis->length] - axis->edges[0]) / (double)axis->length;
    }
    ty_netcdf_release(file, variable);
    return result == TY_ERROR_MEMORY ? result : TY_OK;
}

ty_result ty_netcdf_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                         int32_t* count) {
    ty_netcdf_file file;
    ty_netcdf_variable variable;
    int variables = 0;
    int32_t found = 0;
    ty_result result = ty_netcdf_open(context, path, &file);
    if (result != TY_OK) return result;
    result = count_variables(&file, &variables);
    file.quiet = true;
    for (int i = 0; i < variables && result == TY_OK; ++i) {
        if (!is_volume(&file, i, &variable)) continue;
        if (found < capacity) result = fill_entry(&file, &variable, &entries[found]);
        ++found;
    }
    if (result == TY_OK) *count = found;
    ty_netcdf_close(&file);
    return result;
}

#else

static ty_result fail_without(ty_context* context, const char* path) {
    return ty_fail(context, TY_ERROR_INPUT, "%s: this build reads no NetCDF files, which take libnetcdf", path);
}

ty_result ty_netcdf_read(ty_context* context, const char* path, const ty_volume_def* def, double* radius,
                         ty_grid** out) {
    (void)def;
    (void)radius;
    (void)out;
    return fail_without(context, path);
}

ty_result ty_netcdf_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out) {
    (void)def;
    (void)out;
    return fail_without(context, path);
}

ty_result ty_netcdf_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                         int32_t* count) {
    (void)entries;
    (void)capacity;
    (void)count;
    return fail_without(context, path);
}

#endif
