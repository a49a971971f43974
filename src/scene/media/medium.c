/* Media: checks, and their views for kernels. */
#include "scene/media/medium.h"

#include "base/context.h"
#include "scene/media/blackbody.h"
#include "base/check.h"
#include "scene/surfaces/closed_mesh.h"
#include "scene/media/phase.h"

void ty_init_medium_def(void* def, size_t bytes) {
    const ty_medium_def own = {
        .name = "", .transform = ty_affine_identity(), .scale = 1, .kelvin = {0, 1}, .emission_scale = 1};
    ty_init_def(def, bytes, &own, sizeof own);
}

static ty_result check_bounds(ty_context* context, const ty_medium_def* def) {
    const bool placed = def->density_grid != NULL && ty_grid_get_info(def->density_grid).placed;
    switch (def->bounds) {
    case TY_BOUNDS_NONE:
        if (placed) return TY_OK;
        return ty_fail(context, TY_ERROR_ARGUMENT, "medium.bounds: %s needs bounds to fill",
                       def->density_grid != NULL ? "a grid without a transform" : "a homogeneous medium");
    case TY_BOUNDS_BOX: {
        ty_result result = ty_check_point(context, "medium.box_min", def->box_min);
        if (result == TY_OK) result = ty_check_point(context, "medium.box_max", def->box_max);
        for (int a = 0; a < 3 && result == TY_OK; ++a)
            if (!(def->box_max[a] > def->box_min[a]))
                result = ty_fail(context, TY_ERROR_ARGUMENT,
                                 "medium.bounds: the box's upper corner must be above its lower in %c", "xyz"[a]);
        return result;
    }
    case TY_BOUNDS_SPHERE:
        if (def->density_grid != NULL && !placed)
            return ty_fail(context, TY_ERROR_ARGUMENT,
                           "medium.bounds: a grid without a transform fills a box, not a sphere");
        if (!(def->sphere_radius > 0 && def->sphere_radius <= 1e15))
            return ty_fail(context, TY_ERROR_ARGUMENT, "medium.sphere_radius: %g is outside (0, 1e15]",
                           def->sphere_radius);
        return ty_check_point(context, "medium.sphere_center", def->sphere_center);
    case TY_BOUNDS_SHELL:
        if (def->shell == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "medium.shell: it is NULL");
        if (def->density_grid != NULL && !placed)
            return ty_fail(context, TY_ERROR_ARGUMENT,
                           "medium.bounds: a grid without a transform fills a box, not a closed mesh");
        return TY_OK;
    }
    return ty_fail(context, TY_ERROR_ARGUMENT, "medium.bounds: %d is not a ty_bounds_kind", (int)def->bounds);
}

static ty_result check_transfer(ty_context* context, const ty_medium_def* def) {
    if (def->transfer_count == 0) {
        if (!def->transfer_albedo) return TY_OK;
        return ty_fail(context, TY_ERROR_ARGUMENT, "medium.transfer_albedo: there is no transfer function");
    }
    if (def->transfer == NULL || def->transfer_count < 2 || def->transfer_count > TY_TRANSFER_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "medium.transfer: %d points are not 2..%d", def->transfer_count,
                       (int)TY_TRANSFER_MAX);
    if (def->density_grid == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "medium.transfer: there is no density grid to look it up with");
    for (int32_t i = 0; i < def->transfer_count; ++i) {
        const ty_transfer_point* point = &def->transfer[i];
        if (!isfinite(point->value) || (i > 0 && !(point->value > def->transfer[i - 1].value)))
            return ty_fail(context, TY_ERROR_ARGUMENT, "medium.transfer[%d].value: %g is not above the one before", i,
                           (double)point->value);
        if (!(point->density >= 0 && (double)point->density <= TY_COLOR_MAX))
            return ty_fail(context, TY_ERROR_ARGUMENT, "medium.transfer[%d].density: %g is outside [0, %g]", i,
                           (double)point->density, TY_COLOR_MAX);
        const ty_result result = ty_check_rgb(context, "medium.transfer.albedo", point->albedo, 0, 1);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

/* Fields without a placement need a box to fill, like densities. */
static ty_result check_fields(ty_context* context, const ty_medium_def* def) {
    const int albedos = (def->albedo_grid[0] != NULL) + (def->albedo_grid[1] != NULL) + (def->albedo_grid[2] != NULL);
    if (albedos != 0 && albedos != 3)
        return ty_fail(context, TY_ERROR_ARGUMENT, "medium.albedo_grid: give three grids or none");
    if (albedos != 0 && def->transfer_albedo)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "medium.albedo_grid: the transfer function gives the albedo already");
    ty_grid* grids[TY_MEDIUM_GRIDS];
    ty_medium_grids(def, grids);
    for (int i = 1; i < TY_MEDIUM_GRIDS; ++i)
        if (grids[i] != NULL && def->bounds != TY_BOUNDS_BOX && !ty_grid_get_info(grids[i]).placed)
            return ty_fail(context, TY_ERROR_ARGUMENT, "medium: a field without a transform needs a box to fill");
    ty_result result = ty_check_rgb(context, "medium.emission", def->emission, 0, TY_COLOR_MAX);
    if (result == TY_OK)
        result = ty_check_number(context, "medium.emission_scale", (double)def->emission_scale, 0, TY_COLOR_MAX);
    for (int i = 0; i < 2 && result == TY_OK; ++i)
        result = ty_check_number(context, "medium.kelvin", def->kelvin[i], -1e9, 1e9);
    return result;
}

static ty_result check_phase(ty_context* context, const ty_medium_def* def) {
    for (int c = 0; c < 3; ++c)
        if (!(def->g[c] > -1 && def->g[c] < 1))
            return ty_fail(context, TY_ERROR_ARGUMENT, "medium.g[%d]: %g is outside (-1, 1)", c, (double)def->g[c]);
    if (def->phase_count == 0) return TY_OK;
    if (def->g[0] != 0 || def->g[1] != 0 || def->g[2] != 0 || def->g_grid != NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "medium.g: medium.phase gives the phase function already");
    return ty_phase_check(context, "medium.phase", def->phase, def->phase_count);
}

ty_result ty_medium_check(ty_context* context, const ty_medium_def** given, ty_medium_def* own) {
    *own = ty_default_medium_def();
    ty_result result = ty_take_def(context, *given, "ty_default_medium_def", own, sizeof *own);
    const ty_medium_def* def = *given = own;
    if (result == TY_OK) result = ty_check_affine(context, "medium.transform", &def->transform);
    if (result == TY_OK) result = ty_check_rgb(context, "medium.sigma_s", def->sigma_s, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_rgb(context, "medium.sigma_a", def->sigma_a, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_number(context, "medium.scale", def->scale, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = check_phase(context, def);
    if (result == TY_OK) result = check_transfer(context, def);
    if (result == TY_OK) result = check_fields(context, def);
    return result == TY_OK ? check_bounds(context, def) : result;
}

ty_result ty_medium_mean_cosine(ty_context* context, const ty_medium_def* medium, float g[3]) {
    if (medium == NULL || g == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_medium_mean_cosine: medium or g is NULL");
    memcpy(g, medium->g, sizeof medium->g);
    if (medium->phase_count == 0) return TY_OK;
    double moments[6];
    const ty_result result = ty_phase_moments(context, medium->phase, medium->phase_count, 1, moments);
    for (int c = 0; c < 3 && result == TY_OK; ++c) g[c] = (float)moments[2 * c + 1];
    return result;
}

/* ---- copies ---- */

void ty_medium_grids(const ty_medium_def* def, ty_grid* grids[TY_MEDIUM_GRIDS]) {
    grids[0] = def->density_grid;
    for (int c = 0; c < 3; ++c) grids[1 + c] = def->albedo_grid[c];
    grids[4] = def->g_grid;
    grids[5] = def->temperature_grid;
}

bool ty_medium_copy(ty_context* context, const ty_medium_def* def, ty_medium_def* out) {
    const size_t points = (size_t)def->transfer_count;
    *out = *def;
    char* name = ty_copy_text(context, def->name);
    ty_transfer_point* transfer = ty_alloc_array(context, points, sizeof *transfer, false);
    if (name == NULL || transfer == NULL || !ty_phase_copy_tables(context, def->phase, def->phase_count, out->phase)) {
        ty_free_text(context, name);
        ty_free_array(context, transfer, points, sizeof *transfer);
        return false;
    }
    if (points > 0) memcpy(transfer, def->transfer, points * sizeof *transfer);
    out->name = name;
    out->transfer = transfer;
    ty_grid* grids[TY_MEDIUM_GRIDS];
    ty_medium_grids(out, grids);
    for (int i = 0; i < TY_MEDIUM_GRIDS; ++i) ty_grid_retain(grids[i]);
    ty_closed_mesh_retain(out->shell);
    return true;
}

void ty_medium_release(ty_context* context, ty_medium_def* copy) {
    ty_grid* grids[TY_MEDIUM_GRIDS];
    ty_medium_grids(copy, grids);
    for (int i = 0; i < TY_MEDIUM_GRIDS; ++i) ty_grid_release(grids[i]);
    ty_closed_mesh_release(copy->shell);
    ty_free_text(context, (char*)copy->name);
    ty_free_array(context, (void*)copy->transfer, (size_t)copy->transfer_count, sizeof *copy->transfer);
    ty_phase_free_tables(context, copy->phase, copy->phase_count);
}

/* ---- views ---- */

/* Map from the space where bounds are the cube [-1, 1]^3 or the unit sphere to the medium's local space. */
static ty_affine bounds_to_local(const ty_medium_def* def) {
    double center[3], half[3];
    const double none[3] = {0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        const bool box = def->bounds == TY_BOUNDS_BOX;
        center[a] = box ? (def->box_min[a] + def->box_max[a]) / 2 : def->sphere_center[a];
        half[a] = box ? (def->box_max[a] - def->box_min[a]) / 2 : def->sphere_radius;
    }
    return ty_affine_compose(center, none, half);
}

ty_affine ty_medium_bounds_map(const ty_medium_def* def) {
    const ty_affine local = bounds_to_local(def);
    return ty_affine_multiply(&def->transform, &local);
}

/* Map from a grid's index space to the medium's local space. */
static ty_affine index_to_local(const ty_medium_def* def, const ty_grid_info* grid) {
    if (grid->placed) return grid->index_to_local;
    double corner[3], cell[3];
    const double none[3] = {0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        cell[a] = (def->box_max[a] - def->box_min[a]) / grid->size[a];
        corner[a] = def->box_min[a] + cell[a] / 2;
    }
    return ty_affine_compose(corner, none, cell);
}

static void invert_to_floats(const ty_affine* map, float out[12]) {
    ty_affine inverse = ty_affine_identity();
    ty_affine_invert(map, &inverse);
    for (int i = 0; i < 12; ++i) out[i] = (float)inverse.m[i];
}

/* True if a grid whose index space `map` takes into the scene spans the cell along an axis, from face to face. */
static bool spans_cell(const ty_periodic_view* cell, const ty_affine* map, const int32_t size[3], int32_t axis) {
    if ((cell->axes >> axis & 1) == 0) return false;
    const double step = map->m[4 * axis + axis];
    for (int b = 0; b < 3; ++b)
        if (b != axis && (fabs(map->m[4 * axis + b]) > 1e-6 * step || fabs(map->m[4 * b + axis]) > 1e-6 * step))
            return false;
    const double lower = map->m[4 * axis + 3] - 0.5 * step, upper = lower + step * size[axis];
    return step > 0 && fabs(lower - (double)cell->lower[axis]) < 0.01 * step &&
           fabs(upper - (double)cell->upper[axis]) < 0.01 * step;
}

static ty_grid_view place_grid(const ty_medium_def* def, const ty_periodic_view* cell, const ty_grid* grid,
                               float to_index[12]) {
    const ty_grid_info info = ty_grid_get_info(grid);
    const ty_affine local = index_to_local(def, &info);
    const ty_affine world = ty_affine_multiply(&def->transform, &local);
    invert_to_floats(&world, to_index);
    ty_grid_view view = ty_grid_get_view(grid);
    for (int32_t a = 0; a < 3; ++a)
        if (spans_cell(cell, &world, info.size, a)) view.wraps |= 1 << a;
    return view;
}

static ty_field_view place_field(const ty_medium_def* def, const ty_periodic_view* cell, const ty_grid* grid) {
    ty_field_view field;
    field.grid = place_grid(def, cell, grid, field.to_index);
    return field;
}

static size_t brick_count(const ty_grid_view* grid) {
    return (size_t)grid->bricks[0] * (size_t)grid->bricks[1] * (size_t)grid->bricks[2];
}

/* Minimum and maximum density for values in [low, high]. */
static void transfer_extremes(const ty_transfer_point* points, int32_t count, float low, float high, float out[2]) {
    const float ends[2] = {ty_transfer_density(points, count, low), ty_transfer_density(points, count, high)};
    out[0] = ty_minf(ends[0], ends[1]);
    out[1] = ty_maxf(ends[0], ends[1]);
    for (int32_t i = 0; i < count; ++i) {
        if (points[i].value <= low || points[i].value >= high) continue;
        out[0] = ty_minf(out[0], points[i].density);
        out[1] = ty_maxf(out[1], points[i].density);
    }
}

/* Interpolation at the faces of a periodic cell reaches over to the opposite face: the bricks at both have common
 * extremes. */
static void wrap_extremes(const ty_grid_view* grid, int32_t axis, float* extremes) {
    const size_t strides[3] = {1, (size_t)grid->bricks[0], (size_t)grid->bricks[0] * (size_t)grid->bricks[1]};
    const int32_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    const size_t across = (size_t)(grid->bricks[axis] - 1) * strides[axis];
    for (int32_t j = 0; j < grid->bricks[b]; ++j)
        for (int32_t k = 0; k < grid->bricks[c]; ++k) {
            float* first = extremes + 2 * ((size_t)j * strides[b] + (size_t)k * strides[c]);
            float* last = first + 2 * across;
            first[0] = last[0] = ty_minf(first[0], last[0]);
            first[1] = last[1] = ty_maxf(first[1], last[1]);
        }
}

/* Replaces brick extremes of the grid's values by those of the density. */
static ty_result own_extremes(ty_context* context, const ty_medium_def* def, ty_medium_view* view) {
    view->transfer = def->transfer_count > 0 ? def->transfer : NULL;
    view->transfer_count = def->transfer_count;
    view->transfer_albedo = def->transfer_albedo;
    const size_t bricks = brick_count(&view->grid);
    float* extremes = ty_alloc_array(context, bricks, 2 * sizeof *extremes, false);
    view->extremes = extremes;
    view->owns_extremes = 1;
    if (extremes == NULL) return TY_ERROR_MEMORY;
    memcpy(extremes, view->grid.extremes, bricks * 2 * sizeof *extremes);
    for (int32_t a = 0; a < 3; ++a)
        if ((view->grid.wraps >> a & 1) != 0) wrap_extremes(&view->grid, a, extremes);
    for (size_t i = 0; i < bricks && view->transfer != NULL; ++i)
        transfer_extremes(def->transfer, def->transfer_count, extremes[2 * i], extremes[2 * i + 1], extremes + 2 * i);
    return TY_OK;
}

static void view_coefficients(const ty_medium_def* def, ty_medium_view* view) {
    view->gray = view->gray_g = 1;
    for (int c = 0; c < 3; ++c) {
        view->sigma_s[c] = def->scale * def->sigma_s[c];
        view->sigma_t[c] = def->scale * (def->sigma_s[c] + def->sigma_a[c]);
        view->sigma_t_max = ty_maxf(view->sigma_t_max, view->sigma_t[c]);
        view->uniform_albedo[c] = view->sigma_t[c] > 0.0f ? view->sigma_s[c] / view->sigma_t[c] : 0.0f;
        view->g[c] = def->g[c];
        if (view->sigma_t[c] != view->sigma_t[0]) view->gray = 0;
        if (view->g[c] != view->g[0]) view->gray_g = 0;
    }
}

/* The phase function, and its mean cosine as g. */
static ty_result view_phase(ty_context* context, const ty_medium_def* def, ty_medium_view* view) {
    if (def->phase_count == 0) return TY_OK;
    ty_phase_view* phase = NULL;
    const ty_result result = ty_phase_view_create(context, def->phase, def->phase_count, &phase);
    view->phase = phase;
    if (result != TY_OK) return result;
    view->gray_g = phase->gray;
    for (int c = 0; c < 3; ++c) view->g[c] = phase->moments[c][1];
    return TY_OK;
}

/* Albedo, g and temperature fields, and emission. */
static ty_result view_fields(ty_context* context, const ty_medium_def* def, const ty_periodic_view* cell,
                             ty_medium_view* view) {
    if (def->albedo_grid[0] != NULL) {
        const bool one = def->albedo_grid[1] == def->albedo_grid[0] && def->albedo_grid[2] == def->albedo_grid[0];
        view->albedo_fields = one ? 1 : 3;
        for (int c = 0; c < view->albedo_fields; ++c) view->albedo[c] = place_field(def, cell, def->albedo_grid[c]);
    }
    if (def->g_grid != NULL) {
        view->has_g_field = 1;
        view->gray_g = 1;
        view->g_field = place_field(def, cell, def->g_grid);
    }
    memcpy(view->emission, def->emission, sizeof view->emission);
    view->emits = def->emission[0] > 0 || def->emission[1] > 0 || def->emission[2] > 0;
    if (def->temperature_grid == NULL || !(def->emission_scale > 0)) return TY_OK;
    view->has_temperature = view->emits = 1;
    view->temperature = place_field(def, cell, def->temperature_grid);
    view->kelvin[0] = (float)def->kelvin[0];
    view->kelvin[1] = (float)(def->kelvin[1] - def->kelvin[0]);
    view->blackbody_scale = def->emission_scale;
    ty_blackbody_table* table = ty_alloc_array(context, 1, sizeof *table, false);
    if (table == NULL) return TY_ERROR_MEMORY;
    ty_blackbody_fill(table);
    view->blackbody = table;
    return TY_OK;
}

/* Tentative collisions sample the emission of a varying medium: one that hardly absorbs, such as a clear flame, would
 * have few of them and much noise. This many are expected along its diagonal. */
static float emission_majorant(const ty_medium_def* def, const ty_medium_view* view) {
    const double points = 8;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    float densest = view->has_grid != 0 ? 0.0f : 1.0f;
    if (view->emits == 0) return 0;
    for (size_t i = 0; view->has_grid != 0 && i < brick_count(&view->grid); ++i)
        densest = ty_maxf(densest, view->extremes[2 * i + 1]);
    ty_medium_extent(def, lower, upper);
    const double diagonal = hypot(hypot(upper[0] - lower[0], upper[1] - lower[1]), upper[2] - lower[2]);
    const double thickness = (double)view->sigma_t_max * diagonal;
    return thickness > 0 && thickness * (double)densest < 1 ? (float)(points / thickness) : 0;
}

ty_result ty_medium_view_create(ty_context* context, const ty_medium_def* def, const ty_periodic_view* cell,
                                ty_medium_view* view) {
    memset(view, 0, sizeof *view);
    view->bounds = (int32_t)def->bounds;
    if (def->bounds == TY_BOUNDS_SHELL) {
        invert_to_floats(&def->transform, view->to_bounds);
        view->shell = def->shell->mesh;
    } else if (def->bounds != TY_BOUNDS_NONE) {
        const ty_affine world = ty_medium_bounds_map(def);
        invert_to_floats(&world, view->to_bounds);
    }
    view_coefficients(def, view);
    ty_result result = view_phase(context, def, view);
    if (result == TY_OK && def->density_grid != NULL) {
        view->has_grid = 1;
        view->grid = place_grid(def, cell, def->density_grid, view->to_index);
        view->extremes = view->grid.extremes;
        if (def->transfer_count > 0 || view->grid.wraps != 0) result = own_extremes(context, def, view);
    }
    if (result == TY_OK) result = view_fields(context, def, cell, view);
    if (result == TY_OK) view->emission_majorant = emission_majorant(def, view);
    view->heterogeneous = view->has_grid || view->albedo_fields > 0 || view->has_g_field || view->has_temperature;
    return result;
}

void ty_medium_view_destroy(ty_context* context, ty_medium_view* view) {
    if (view->owns_extremes != 0)
        ty_free_array(context, (void*)view->extremes, brick_count(&view->grid), 2 * sizeof(float));
    ty_free_array(context, (void*)view->blackbody, 1, sizeof *view->blackbody);
    ty_phase_view_destroy(context, view->phase);
}

/* margin: of grids without bounds, beyond the centres of their outermost voxels, in voxels. */
static void extend_by(const ty_medium_def* def, double margin, double lower[3], double upper[3]) {
    ty_affine local;
    double low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    if (def->bounds == TY_BOUNDS_SHELL) {
        local = ty_affine_identity();
        memcpy(low, def->shell->triangles->lower, sizeof low);
        memcpy(high, def->shell->triangles->upper, sizeof high);
    } else if (def->bounds != TY_BOUNDS_NONE) {
        local = bounds_to_local(def);
    } else {
        const ty_grid_info info = ty_grid_get_info(def->density_grid);
        local = info.index_to_local;
        for (int a = 0; a < 3; ++a) {
            low[a] = -margin;
            high[a] = info.size[a] - 1 + margin;
        }
    }
    const ty_affine world = ty_affine_multiply(&def->transform, &local);
    for (int corner = 0; corner < 8; ++corner) {
        double point[3];
        for (int a = 0; a < 3; ++a) point[a] = (corner >> a & 1) != 0 ? high[a] : low[a];
        ty_affine_point(&world, point, point);
        for (int a = 0; a < 3; ++a) {
            lower[a] = fmin(lower[a], point[a]);
            upper[a] = fmax(upper[a], point[a]);
        }
    }
}

void ty_medium_extent(const ty_medium_def* def, double lower[3], double upper[3]) {
    extend_by(def, 1, lower, upper);
}

void ty_medium_voxel_extent(const ty_medium_def* def, double lower[3], double upper[3]) {
    extend_by(def, 0.5, lower, upper);
}
