/* Grids of NetCDF variables, slab by slab: values in the order of the grid, the extinction of droplets, and even cells
 * for uneven ones. */
#include "io/volumes/netcdf/netcdf.h"

#include "base/context.h"
#include "grid/grid.h"
#include "io/volumes/volume_file.h"

#if TYNDALL_NETCDF

#include <math.h>
#include <string.h>

/* Even cells along an axis; even voxels for each uneven one, or up to a million of them. */
enum { LEVELS_MAX = 2048, ENLARGEMENT_MAX = 32, ENLARGED_MIN = 1 << 20 };

typedef struct slabs {
    const ty_netcdf_file* file;
    const ty_netcdf_variable* variable;
    ty_netcdf_companion own; /* the variable's values */
    ty_netcdf_droplets* d;   /* NULL: the values are what is wanted */
    int64_t size[3];         /* of the grid */
    size_t counted;          /* slices of the file from the lowest on whose droplets were counted */
    float* values;           /* of TY_GRID_BLOCK slices */
} slabs;

static bool is_uneven(const ty_netcdf_axis* axis) {
    return axis->placed && !axis->even;
}

/* ---- even cells ---- */

/* Number of even cells for an uneven axis: as wide as its narrowest one, if they are not too many. `others`: cells
 * across it; `largest`: cells of a grid. */
static size_t even_count(const ty_netcdf_axis* axis, double others, double largest) {
    double narrowest = INFINITY;
    for (size_t i = 0; i < axis->length; ++i) narrowest = fmin(narrowest, axis->edges[i + 1] - axis->edges[i]);
    const double count = round((axis->edges[axis->length] - axis->edges[0]) / narrowest);
    const double max = fmax((double)axis->length, fmin(LEVELS_MAX, largest / others));
    return (size_t)fmin(count, floor(max));
}

/* Sets the grid's size, with even cells along uneven axes. */
static ty_result find_size(slabs* s) {
    const ty_netcdf_variable* variable = s->variable;
    double voxels = 1;
    for (int a = 0; a < 3; ++a) {
        s->size[a] = (int64_t)variable->axes[a].length;
        voxels *= (double)s->size[a];
    }
    const double largest = fmax(ENLARGEMENT_MAX * voxels, ENLARGED_MIN);
    for (int a = 0; a < 3; ++a) {
        const ty_netcdf_axis* axis = &variable->axes[a];
        size_t checked = 0;
        if (!is_uneven(axis)) continue;
        const double before = (double)s->size[0] * (double)s->size[1] * (double)s->size[2];
        s->size[a] = (int64_t)even_count(axis, before / (double)axis->length, largest);
        const ty_result result = ty_check_volume_size(s->file->context, s->file->path, s->size, &checked);
        if (result != TY_OK) return result;
        ty_log(s->file->context, TY_LOG_WARNING,
               "%s: \"%s\" has uneven cells along %c; its %zu became %lld even ones with the same integral",
               s->file->path, variable->name, "xyz"[a], axis -> length, (long long)s -> size[a]);
    }
    return TY_OK;
}

/* A range of an axis: cells of the file, in ascending order, and even ones that they give. */
typedef struct range {
    size_t first, end;           /* cells */
    size_t even_first, even_end; /* of `even_count` */
    size_t even_count;
} range;

/* Averages of one line of cells over even ones: the integral stays. `from` begins at the range's first cell. */
static void resample_line(const ty_netcdf_axis* axis, const range* r, const float* from, size_t stride, float* to) {
    const double low = axis->edges[0], step = (axis->edges[axis->length] - low) / (double)r->even_count;
    size_t i = r->first;
    for (size_t o = r->even_first; o < r->even_end; ++o) {
        const double begin = low + step * (double)o, end = begin + step;
        double sum = 0;
        for (; i < r->end; ++i) {
            const double overlap = fmin(end, axis->edges[i + 1]) - fmax(begin, axis->edges[i]);
            if (overlap > 0) sum += overlap * (double)from[(i - r->first) * stride];
            if (axis->edges[i + 1] > end) break;
        }
        to[(o - r->even_first) * stride] = (float)(sum / step);
    }
}

/* Cells with a part in even ones. */
static range cells_of(const ty_netcdf_axis* axis, size_t even_count, size_t even_first, size_t even_end) {
    const double low = axis->edges[0], step = (axis->edges[axis->length] - low) / (double)even_count;
    const double begin = low + step * (double)even_first;
    const double end = low + step * (double)(even_end - 1) + step;
    range r = {0, axis->length, even_first, even_end, even_count};
    while (r.first + 1 < axis->length && !(axis->edges[r.first + 1] > begin)) ++r.first;
    while (r.end > r.first + 1 && !(axis->edges[r.end - 1] < end)) --r.end;
    return r;
}

/* Makes one axis even; *values, of `size` values, become others. */
static ty_result resample_axis(const slabs* s, int a, const range* r, size_t size[3], float** values) {
    ty_context* context = s->file->context;
    const size_t before = size[0] * size[1] * size[2], cells = r->end - r->first, even = r->even_end - r->even_first;
    size_t inner = 1, outer = 1;
    for (int b = 0; b < a; ++b) inner *= size[b];
    for (int b = a + 1; b < 3; ++b) outer *= size[b];
    float* made = ty_alloc_array(context, inner * outer * even, sizeof *made, false);
    if (made == NULL) return TY_ERROR_MEMORY;
    for (size_t o = 0; o < outer; ++o)
        for (size_t i = 0; i < inner; ++i)
            resample_line(&s->variable->axes[a], r, *values + o * inner * cells + i, inner,
                          made + o * inner * even + i);
    ty_free_array(context, *values, before, sizeof **values);
    *values = made;
    size[a] = even;
    return TY_OK;
}

/* ---- slabs ---- */

/* Sorts slices [first, end) into x, y, z order, ascending; by the droplets' extinction if there are some. */
static void arrange(slabs* s, size_t first, size_t end, float* to) {
    const ty_netcdf_axis* axes = s->variable->axes;
    size_t at[3], out = 0;
    for (size_t k = first; k < end; ++k) {
        if (s->d != NULL) s->d->counting = k >= s->counted;
        for (size_t j = 0; j < axes[1].length; ++j)
            for (size_t i = 0; i < axes[0].length; ++i, ++out) {
                const size_t index[3] = {i, j, k};
                for (int a = 0; a < 3; ++a) at[a] = axes[a].descending ? axes[a].length - 1 - index[a] : index[a];
                const double value = ty_netcdf_companion_value(&s->own, at);
                to[out] = s->d != NULL ? (float)ty_netcdf_extinction(s->d, value, at) : (float)value;
            }
    }
    if (end > s->counted) s->counted = end;
}

/* Reads slices [first, end), counted in ascending order, of all variables. */
static ty_result load(slabs* s, size_t first, size_t end) {
    const ty_netcdf_axis* z = &s->variable->axes[2];
    const size_t begin = z->descending ? z->length - end : first;
    ty_result result = ty_netcdf_load_companion(s->file, &s->own, begin, end - first);
    if (s->d == NULL) return result;
    if (result == TY_OK) result = ty_netcdf_load_companion(s->file, &s->d->radius, begin, end - first);
    return result == TY_OK ? ty_netcdf_load_companion(s->file, &s->d->air, begin, end - first) : result;
}

static ty_result make_even(slabs* s, const range* z, float** values, size_t* count) {
    size_t size[3] = {s->variable->axes[0].length, s->variable->axes[1].length, z->end - z->first};
    ty_result result = TY_OK;
    for (int a = 0; a < 3 && result == TY_OK; ++a) {
        const ty_netcdf_axis* axis = &s->variable->axes[a];
        const range whole = {0, axis->length, 0, (size_t)s->size[a], (size_t)s->size[a]};
        if (is_uneven(axis)) result = resample_axis(s, a, a == 2 ? z : &whole, size, values);
    }
    *count = size[0] * size[1] * size[2];
    return result;
}

/* As ty_slice_source. */
static ty_result read_slices(void* user, int32_t first, int32_t count, const void** values) {
    slabs* s = user;
    ty_context* context = s->file->context;
    const ty_netcdf_axis* axes = s->variable->axes;
    const size_t begin = (size_t)first, end = begin + (size_t)count;
    range z = {begin, end, begin, end, (size_t)s->size[2]};
    if (is_uneven(&axes[2])) z = cells_of(&axes[2], (size_t)s->size[2], begin, end);
    ty_result result = load(s, z.first, z.end);
    if (result != TY_OK) return result;
    *values = s->values;
    if (!is_uneven(&axes[0]) && !is_uneven(&axes[1]) && !is_uneven(&axes[2])) {
        arrange(s, z.first, z.end, s->values);
        return TY_OK;
    }
    size_t made = axes[0].length * axes[1].length * (z.end - z.first);
    float* cells = ty_alloc_array(context, made, sizeof *cells, false);
    if (cells == NULL) return TY_ERROR_MEMORY;
    arrange(s, z.first, z.end, cells);
    result = make_even(s, &z, &cells, &made);
    if (result == TY_OK) memcpy(s->values, cells, made * sizeof *cells);
    ty_free_array(context, cells, made, sizeof *cells);
    return result;
}

static ty_grid_def describe(const slabs* s) {
    ty_grid_def def = ty_default_grid_def();
    def.placed = s->variable->axes[0].placed;
    for (int a = 0; a < 3; ++a) {
        const ty_netcdf_axis* axis = &s->variable->axes[a];
        def.size[a] = (int32_t)s->size[a];
        if (!def.placed) continue;
        const double step = (axis->edges[axis->length] - axis->edges[0]) / (double)s->size[a];
        def.index_to_local.m[5 * a] = step;
        def.index_to_local.m[4 * a + 3] = axis->edges[0] + step / 2;
    }
    return def;
}

ty_result ty_netcdf_make_grid(const ty_netcdf_file* file, const ty_netcdf_variable* variable, int32_t time,
                              ty_netcdf_droplets* droplets, const ty_grid_plan* plan, ty_grid** out) {
    slabs s = {.file = file, .variable = variable, .d = droplets, .own = {.given = true, .unit = 1}};
    s.own.variable = *variable;
    ty_result result = ty_netcdf_aim(file, variable, time, &s.own);
    if (result == TY_OK) result = find_size(&s);
    if (result != TY_OK) return result;
    const ty_grid_def def = describe(&s);
    const size_t slices = def.size[2] < TY_GRID_BLOCK ? (size_t)def.size[2] : (size_t)TY_GRID_BLOCK;
    const size_t count = slices * (size_t)def.size[0] * (size_t)def.size[1];
    s.values = ty_alloc_array(file->context, count, sizeof *s.values, false);
    const ty_slice_source source = {read_slices, &s, 0, 0};
    result =
        s.values == NULL ? TY_ERROR_MEMORY : ty_grid_create_from_slices(file->context, &def, plan, &source, false, out);
    ty_netcdf_release_companion(file, &s.own);
    ty_free_array(file->context, s.values, count, sizeof *s.values);
    return result;
}

#endif
