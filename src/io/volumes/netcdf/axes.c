/* Axes of NetCDF variables: which dimension is x, y and z, and the edges of cells along them, by the conventions of
 * docs/formats.md. */
#include "io/volumes/netcdf/netcdf.h"

#include "base/context.h"
#include "grid/grid.h"

#if TYNDALL_NETCDF

#include "io/volumes/netcdf/calls.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Axes of space are 0 to 2. */
enum { AXIS_NONE = -1, AXIS_TIME = 3, AXIS_FURTHER = 4 };

/* Part of a step by which coordinates, which files round, may be off and still count as even. */
static const double uneven = 1e-3;

/* A status of the library. */
static int describe(const ty_netcdf_file* file, int id, ty_netcdf_variable* variable) {
    int dimensions[NC_MAX_VAR_DIMS], attributes = 0;
    nc_type type = NC_NAT;
    *variable = (ty_netcdf_variable){.id = id, .times = -1};
    int status =
        file->calls->inq_var(file->id, id, variable->name, &type, &variable->dimension_count, dimensions, &attributes);
    variable->type = type;
    if (status == NC_NOERR && variable->dimension_count > TY_NETCDF_DIMENSIONS_MAX) status = NC_EMAXDIMS;
    for (int d = 0; d < variable->dimension_count && status == NC_NOERR; ++d) {
        char name[NC_MAX_NAME + 1];
        variable->dimensions[d] = dimensions[d];
        status = file->calls->inq_dim(file->id, dimensions[d], name, &variable->lengths[d]);
    }
    return status;
}

ty_result ty_netcdf_describe(const ty_netcdf_file* file, int id, ty_netcdf_variable* variable) {
    const int status = describe(file, id, variable);
    return status == NC_NOERR ? TY_OK : ty_netcdf_fail(file, status);
}

/* ---- which axis a dimension is ---- */

static bool begins(const char* name, const char* const* words) {
    for (; *words != NULL; ++words)
        if (strncasecmp(name, *words, strlen(*words)) == 0) return true;
    return false;
}

static int axis_of_letter(char letter) {
    static const char letters[] = "xyzt";
    for (int a = 0; letters[a] != '\0'; ++a)
        if (tolower((unsigned char)letter) == letters[a]) return a;
    return AXIS_NONE;
}

/* By its name: x, xt, x-Grid; west_east; lev, height, bottom_top. */
static int axis_of_name(const char* name) {
    static const char* const along[4][10] = {
        {"lon", "west_east", "easting", "ni", NULL},
        {"lat", "south_north", "northing", "nj", NULL},
        {"lev", "height", "alt", "depth", "bottom_top", "layer", "vertical", "nk", NULL},
        {"time", "nt", "record", NULL}};
    for (int a = 0; a < 4; ++a)
        if (begins(name, along[a])) return a;
    const int axis = axis_of_letter(name[0]);
    return axis == AXIS_TIME && name[1] != '\0' ? AXIS_NONE : axis;
}

/* The variable of one axis that has a name; -1 without one. */
static int find_line(const ty_netcdf_file* file, const char* name, int dimension) {
    ty_netcdf_variable line;
    int id = -1;
    if (file->calls->inq_varid(file->id, name, &id) != NC_NOERR) return -1;
    if (describe(file, id, &line) != NC_NOERR) return -1;
    const bool fits = line.dimension_count == 1 && (dimension < 0 || line.dimensions[0] == dimension);
    return fits && line.type != NC_CHAR && line.type <= NC_UINT64 ? id : -1;
}

static int axis_of(const ty_netcdf_file* file, int dimension) {
    char name[NC_MAX_NAME + 1], text[64];
    size_t length = 0;
    if (file->calls->inq_dim(file->id, dimension, name, &length) != NC_NOERR) return AXIS_NONE;
    const int coordinates = find_line(file, name, dimension);
    if (coordinates < 0) return axis_of_name(name);
    ty_netcdf_text(file, coordinates, "axis", text, sizeof text);
    if (axis_of_letter(text[0]) != AXIS_NONE) return axis_of_letter(text[0]);
    ty_netcdf_text(file, coordinates, "standard_name", text, sizeof text);
    const int axis = text[0] != '\0' ? axis_of_name(text) : AXIS_NONE;
    return axis != AXIS_NONE ? axis : axis_of_name(name);
}

/* The dimension that is the last to be one of space: of times, or of a single value, or the first that none claims. */
static int find_further(const ty_netcdf_variable* variable, const int* axes) {
    for (int pass = 0; pass < 3; ++pass)
        for (int d = 0; d < variable->dimension_count; ++d) {
            if (pass == 0 && axes[d] == AXIS_TIME) return d;
            if (axes[d] == AXIS_NONE && (pass == 2 || (pass == 1 && variable->lengths[d] == 1))) return d;
        }
    return -1;
}

/* Axes of space that no dimension claims are the ones left; the last of them is x. */
static void complete_axes(const ty_netcdf_variable* variable, const int* axes, int found[3]) {
    int d = variable->dimension_count - 1;
    for (int a = 0; a < 3; ++a) {
        if (found[a] >= 0) continue;
        while (d >= 0 && axes[d] != AXIS_NONE && axes[d] != AXIS_TIME) --d;
        found[a] = d--;
    }
}

/* A dimension may stand twice, as those of a covariance do: it would be two axes in one. */
static bool has_twins(const ty_netcdf_variable* variable) {
    for (int d = 0; d < variable->dimension_count; ++d)
        for (int e = 0; e < d; ++e)
            if (variable->dimensions[d] == variable->dimensions[e]) return true;
    return false;
}

bool ty_netcdf_find_axes(const ty_netcdf_file* file, ty_netcdf_variable* variable) {
    int axes[TY_NETCDF_DIMENSIONS_MAX], found[3] = {-1, -1, -1};
    if (variable->type == NC_CHAR || variable->type > NC_UINT64 || variable->dimension_count < 3 || has_twins(variable))
        return false;
    for (int d = 0; d < variable->dimension_count; ++d) {
        axes[d] = axis_of(file, variable->dimensions[d]);
        if (axes[d] < 0 || axes[d] > 2) continue;
        if (found[axes[d]] >= 0)
            axes[d] = AXIS_NONE; /* claimed twice */
        else
            found[axes[d]] = d;
    }
    for (int further = variable->dimension_count - 3; further > 0; --further) {
        const int d = find_further(variable, axes);
        if (d < 0 || (variable->lengths[d] != 1 && variable->times >= 0)) return false;
        if (variable->lengths[d] != 1) variable->times = d;
        axes[d] = AXIS_FURTHER;
    }
    complete_axes(variable, axes, found);
    for (int a = 0; a < 3; ++a) {
        if (found[a] < 0) return false;
        variable->axes[a] = (ty_netcdf_axis){.dimension = found[a], .length = variable->lengths[found[a]]};
    }
    return true;
}

/* ---- coordinates ---- */

/* Fails with a message, unless the file is to be quiet. */
__attribute__((format(printf, 2, 3))) static ty_result refuse(const ty_netcdf_file* file, const char* format, ...) {
    char text[2 * NC_MAX_NAME];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return file->quiet ? TY_ERROR_INPUT : ty_fail(file->context, TY_ERROR_INPUT, "%s: %s", file->path, text);
}

static ty_result wrong_axis(const ty_netcdf_file* file, const char* name, const char* what) {
    return refuse(file, "the coordinates \"%s\" %s", name, what);
}

static ty_result check_status(const ty_netcdf_file* file, int status) {
    if (status == NC_NOERR) return TY_OK;
    return file->quiet && status != NC_ENOMEM ? TY_ERROR_INPUT : ty_netcdf_fail(file, status);
}

static ty_result read_line(const ty_netcdf_file* file, int id, size_t length, size_t values, double* out) {
    const size_t start[2] = {0, 0}, count[2] = {length, values};
    return check_status(file, file->calls->get_vara_double(file->id, id, start, count, out));
}

/* Turns both ends of each cell into edges; false if cells do not meet. */
static bool join_bounds(const double* bounds, size_t length, double* edges) {
    const double tolerance = fabs(bounds[1] - bounds[0]) * uneven;
    for (size_t i = 0; i < length; ++i) {
        edges[i] = bounds[2 * i];
        edges[i + 1] = bounds[2 * i + 1];
        if (i > 0 && !(fabs(bounds[2 * i] - bounds[2 * i - 1]) <= tolerance)) return false;
    }
    return true;
}

/* Edges that a file has: the variable of the attribute `bounds`, two values for each cell, or that of I3RC's domains,
 * x-Edges beside x-Grid. *found tells whether there are any. */
static ty_result read_edges(const ty_netcdf_file* file, const ty_netcdf_variable* variable, const ty_netcdf_axis* axis,
                            const char* name, int coordinates, double* edges, char* units, size_t units_size,
                            bool* found) {
    char other[NC_MAX_NAME + 8];
    ty_netcdf_variable bounds;
    int id = -1;
    const size_t length = strlen(name), suffix = strlen("-Grid");
    *found = false;
    if (length > suffix && strcmp(name + length - suffix, "-Grid") == 0) {
        snprintf(other, sizeof other, "%.*s-Edges", (int)(length - suffix), name);
        id = find_line(file, other, -1);
        if (id < 0 || describe(file, id, &bounds) != NC_NOERR || bounds.lengths[0] != axis->length + 1) return TY_OK;
        ty_netcdf_text(file, id, "units", units, units_size);
        *found = true;
        return read_line(file, id, axis->length + 1, 1, edges);
    }
    if (coordinates < 0) return TY_OK;
    ty_netcdf_text(file, coordinates, "bounds", other, sizeof other);
    if (other[0] == '\0' || file->calls->inq_varid(file->id, other, &id) != NC_NOERR) return TY_OK;
    if (describe(file, id, &bounds) != NC_NOERR || bounds.dimension_count != 2 ||
        bounds.dimensions[0] != variable->dimensions[axis->dimension] || bounds.lengths[1] != 2 ||
        bounds.type == NC_CHAR || bounds.type > NC_UINT64)
        return wrong_axis(file, name, "have bounds that are not two for each of them");
    double* ends = ty_alloc_array(file->context, 2 * axis->length, sizeof *ends, false);
    if (ends == NULL) return TY_ERROR_MEMORY;
    ty_result result = read_line(file, id, axis->length, 2, ends);
    if (result == TY_OK && !join_bounds(ends, axis->length, edges))
        result = wrong_axis(file, name, "have bounds between which there are gaps");
    ty_free_array(file->context, ends, 2 * axis->length, sizeof *ends);
    *found = true;
    return result;
}

/* Edges halfway between coordinates, whose first is edges[0]; a single cell is as wide as `width`. */
static void edges_between(double* edges, size_t length, double width) {
    double before = edges[0];
    if (length == 1) {
        edges[0] = before - width / 2;
        edges[1] = before + width / 2;
        return;
    }
    edges[0] = before - (edges[1] - before) / 2;
    for (size_t i = 1; i < length; ++i) {
        const double here = edges[i];
        edges[i] = (before + here) / 2;
        before = here;
    }
    edges[length] = before + (before - edges[length - 1]);
}

/* Makes edges ascend, and tells whether they are evenly spaced; false unless they go one way and are finite. */
static bool order_edges(ty_netcdf_axis* axis) {
    double* edges = axis->edges;
    const size_t n = axis->length;
    axis->descending = edges[n] < edges[0];
    for (size_t i = 0; axis->descending && i < n - i; ++i) {
        const double other = edges[n - i];
        edges[n - i] = edges[i];
        edges[i] = other;
    }
    const double step = (edges[n] - edges[0]) / (double)n;
    axis->even = true;
    for (size_t i = 0; i <= n; ++i) {
        if (!(fabs(edges[i]) <= 1e15) || (i > 0 && !(edges[i] > edges[i - 1]))) return false;
        if (!(fabs(edges[i] - (edges[0] + step * (double)i)) <= uneven * step)) axis->even = false;
    }
    return true;
}

/* Heights are minus the coordinates of an axis that points down, as those of depth do (CF conventions 4.3). */
static bool points_down(const ty_netcdf_file* file, int coordinates) {
    char text[64];
    ty_netcdf_text(file, coordinates, "positive", text, sizeof text);
    return strcasecmp(text, "down") == 0;
}

/* Coordinates of one axis, in m by their units, divided by the scene's unit; without units as they are. */
static ty_result place_axis(const ty_netcdf_file* file, const ty_netcdf_variable* variable, ty_netcdf_axis* axis,
                            double meters_per_unit, bool* single) {
    char name[NC_MAX_NAME + 1], units[64] = "";
    size_t length = 0;
    bool found = false;
    int status = file->calls->inq_dim(file->id, variable->dimensions[axis->dimension], name, &length);
    if (status != NC_NOERR) return check_status(file, status);
    const int coordinates = find_line(file, name, variable->dimensions[axis->dimension]);
    if (coordinates >= 0) ty_netcdf_text(file, coordinates, "units", units, sizeof units);
    ty_result result = read_edges(file, variable, axis, name, coordinates, axis->edges, units, sizeof units, &found);
    if (result != TY_OK || (!found && coordinates < 0)) return result;
    if (!found) {
        result = read_line(file, coordinates, axis->length, 1, axis->edges);
        if (result != TY_OK) return result;
        *single = axis->length == 1;
        if (!*single) edges_between(axis->edges, axis->length, 0);
    }
    const double unit = units[0] != '\0' ? ty_netcdf_length_unit(units) / meters_per_unit : 1;
    if (unit == 0)
        return refuse(file, "the coordinates \"%s\" are in \"%s\", which is no length; m and km are", name, units);
    const double scale =
        axis == &variable->axes[2] && coordinates >= 0 && points_down(file, coordinates) ? -unit : unit;
    for (size_t i = 0; i < axis->length + (*single ? 0 : 1); ++i) axis->edges[i] *= scale;
    axis->placed = true;
    if (*single || order_edges(axis)) return TY_OK;
    return wrong_axis(file, name, "do not ascend or descend");
}

/* A single cell with one coordinate is as wide as the narrowest of the other axes' cells. */
static void widen_single(ty_netcdf_variable* variable, const bool single[3]) {
    double width = INFINITY;
    for (int a = 0; a < 3; ++a)
        for (size_t i = 0; i < variable->axes[a].length && variable->axes[a].placed && !single[a]; ++i)
            width = fmin(width, variable->axes[a].edges[i + 1] - variable->axes[a].edges[i]);
    for (int a = 0; a < 3; ++a) {
        if (!single[a]) continue;
        edges_between(variable->axes[a].edges, 1, width < INFINITY ? width : 1);
        variable->axes[a].even = true;
    }
}

ty_result ty_netcdf_place(const ty_netcdf_file* file, ty_netcdf_variable* variable, double meters_per_unit) {
    bool single[3] = {false, false, false};
    int placed = 0;
    for (int a = 0; a < 3; ++a) {
        ty_netcdf_axis* axis = &variable->axes[a];
        if (axis->length < 1 || axis->length > TY_GRID_SIDE_MAX)
            return refuse(file, "\"%s\" has %zu values along %c, not 1 to %d", variable->name, axis->length, "xyz"[a],
                          TY_GRID_SIDE_MAX);
        axis->edges = ty_alloc_array(file->context, axis->length + 1, sizeof *axis->edges, true);
        if (axis->edges == NULL) return TY_ERROR_MEMORY;
        const ty_result result = place_axis(file, variable, axis, meters_per_unit, &single[a]);
        if (result != TY_OK) return result;
        placed += axis->placed;
    }
    widen_single(variable, single);
    if (placed == 0 || placed == 3) return TY_OK;
    return refuse(file, "\"%s\" has coordinates along some of its axes, not along all", variable->name);
}

void ty_netcdf_release(const ty_netcdf_file* file, ty_netcdf_variable* variable) {
    for (int a = 0; a < 3; ++a) {
        ty_netcdf_axis* axis = &variable->axes[a];
        ty_free_array(file->context, axis->edges, axis->length + 1, sizeof *axis->edges);
        axis->edges = NULL;
    }
}

#endif
