/* The extinction of droplets by their liquid water content and effective radius, and values that stand beside those of
 * a NetCDF variable. */
#include "io/volumes/netcdf/netcdf.h"

#include "base/context.h"

#if TYNDALL_NETCDF

#include "io/volumes/netcdf/calls.h"

#include <stdio.h>
#include <string.h>

/* ---- values beside those of a variable ---- */

/* Distances between neighbours along x, y and z of another variable in the file's order; 0 along an axis that it does
 * not have. False if it has others than `of`. */
static bool find_strides(const ty_netcdf_variable* variable, const ty_netcdf_variable* of, size_t strides[3]) {
    size_t stride = 1;
    memset(strides, 0, 3 * sizeof *strides);
    for (int d = variable->dimension_count - 1; d >= 0; --d) {
        bool known = variable->lengths[d] == 1 || d == variable->times;
        for (int a = 0; a < 3; ++a)
            if (variable->dimensions[d] == of->dimensions[of->axes[a].dimension]) {
                strides[a] = variable->lengths[d] > 1 ? stride : 0;
                known = true;
            }
        if (!known) return false;
        if (d != variable->times) stride *= variable->lengths[d];
    }
    return true;
}

/* The dimension that is another variable's z, if none of several values stands before it; or -1. */
static int find_slowest(const ty_netcdf_variable* variable, const ty_netcdf_variable* of) {
    int d = 0;
    while (d < variable->dimension_count && (d == variable->times || variable->lengths[d] == 1)) ++d;
    const bool is_z = d < variable->dimension_count && variable->dimensions[d] == of->dimensions[of->axes[2].dimension];
    return is_z ? d : -1;
}

ty_result ty_netcdf_aim(const ty_netcdf_file* file, const ty_netcdf_variable* of, int32_t time,
                        ty_netcdf_companion* companion) {
    ty_netcdf_variable* variable = &companion->variable;
    companion->time = time;
    for (int d = 0; d < variable->dimension_count && of->times >= 0; ++d)
        if (variable->dimensions[d] == of->dimensions[of->times]) variable->times = d;
    if (variable->type == NC_CHAR || variable->type > NC_UINT64 || !find_strides(variable, of, companion->strides))
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: \"%s\" has other axes than \"%s\"", file->path,
                       variable->name, of->name);
    companion->along = find_slowest(variable, of);
    return TY_OK;
}

ty_result ty_netcdf_load_companion(const ty_netcdf_file* file, ty_netcdf_companion* c, size_t first, size_t length) {
    const bool whole = c->along < 0;
    if (!c->given || (whole && c->values != NULL)) return TY_OK;
    ty_netcdf_release_companion(file, c);
    c->first = whole ? 0 : first;
    return ty_netcdf_load(file, &c->variable, c->time, c->along, first, length, &c->values, &c->count);
}

double ty_netcdf_companion_value(const ty_netcdf_companion* c, const size_t at[3]) {
    if (!c->given) return c->constant;
    return c->unit *
           (double)c->values[at[0] * c->strides[0] + at[1] * c->strides[1] + (at[2] - c->first) * c->strides[2]];
}

void ty_netcdf_release_companion(const ty_netcdf_file* file, ty_netcdf_companion* c) {
    ty_free_array(file->context, c->values, c->count, sizeof *c->values);
    c->values = NULL;
}

static ty_result open_companion(const ty_netcdf_file* file, const char* name, const ty_netcdf_variable* of,
                                int32_t time, double (*unit_of)(const char* units), ty_netcdf_companion* out) {
    char units[64];
    int id = -1;
    if (file->calls->inq_varid(file->id, name, &id) != NC_NOERR)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: there is no variable \"%s\"", file->path, name);
    ty_result result = ty_netcdf_describe(file, id, &out->variable);
    if (result == TY_OK) result = ty_netcdf_aim(file, of, time, out);
    if (result != TY_OK) return result;
    out->given = true;
    ty_netcdf_text(file, id, "units", units, sizeof units);
    out->unit = unit_of(units);
    if (out->unit != 0) return TY_OK;
    return ty_fail(file->context, TY_ERROR_INPUT, "%s: \"%s\" is in \"%s\", which is not known", file->path, name,
                   units);
}

void ty_netcdf_release_droplets(const ty_netcdf_file* file, ty_netcdf_droplets* droplets) {
    ty_netcdf_release_companion(file, &droplets->radius);
    ty_netcdf_release_companion(file, &droplets->air);
}

/* ---- droplets ---- */

ty_result ty_netcdf_open_droplets(const ty_netcdf_file* file, const ty_volume_def* def, const ty_netcdf_variable* water,
                                  ty_netcdf_droplets* out) {
    char units[64];
    ty_netcdf_text(file, water->id, "units", units, sizeof units);
    out->water_unit = ty_netcdf_water_unit(units, &out->ratio);
    out->radius.constant = def->droplet_radius;
    out->air.constant = def->air_density_value;
    if (out->water_unit == 0)
        return ty_fail(file->context, TY_ERROR_INPUT,
                       "%s: \"%s\" is in \"%s\", which is no content of water; g m-3 and g/kg are", file->path,
                       water->name, units);
    if (out->ratio && def->air_density == NULL && !(def->air_density_value > 0))
        return ty_fail(file->context, TY_ERROR_INPUT,
                       "%s: \"%s\" is in \"%s\" of air, whose density (air_density) is not given", file->path,
                       water->name, units);
    ty_result result = TY_OK;
    if (def->effective_radius != NULL)
        result =
            open_companion(file, def->effective_radius, water, def->component, ty_netcdf_radius_unit, &out->radius);
    if (result == TY_OK && out->ratio && def->air_density != NULL)
        result = open_companion(file, def->air_density, water, def->component, ty_netcdf_density_unit, &out->air);
    return result;
}

/* sigma_t = 3 LWC / (2 rho_w r_e), 1/m (Stephens 1978). */
double ty_netcdf_extinction(ty_netcdf_droplets* d, double water, const size_t at[3]) {
    static const double water_density = 1000; /* kg m^-3 */
    const double content = water * d->water_unit * (d->ratio ? ty_netcdf_companion_value(&d->air, at) : 1);
    const double radius = ty_netcdf_companion_value(&d->radius, at); /* micrometres */
    if (!(content > 0)) return 0;
    if (!(radius > 0)) {
        d->without_radius += d->counting;
        return 0;
    }
    const double sigma_t = 3 * content / (2 * water_density * radius * 1e-6);
    if (d->counting) {
        d->sum += sigma_t;
        d->sum_radius += sigma_t * radius;
    }
    return sigma_t;
}

#endif
