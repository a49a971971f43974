/* Media: checks, and their views for kernels. */
#include "scene/medium.h"

#include "base/context.h"
#include "scene/check.h"

ty_medium_def ty_default_medium_def(void) {
    return (ty_medium_def){.cookie = TY_DEF_COOKIE, .name = "", .transform = ty_affine_identity(), .scale = 1};
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
    }
    return ty_fail(context, TY_ERROR_ARGUMENT, "medium.bounds: %d is not a ty_bounds_kind", (int)def->bounds);
}

ty_result ty_medium_check(ty_context* context, const ty_medium_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_medium_def");
    if (result == TY_OK) result = ty_check_affine(context, "medium.transform", &def->transform);
    if (result == TY_OK) result = ty_check_rgb(context, "medium.sigma_s", def->sigma_s, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_rgb(context, "medium.sigma_a", def->sigma_a, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_number(context, "medium.scale", def->scale, 0, TY_COLOR_MAX);
    for (int c = 0; c < 3 && result == TY_OK; ++c)
        if (!(def->g[c] > -1 && def->g[c] < 1))
            result = ty_fail(context, TY_ERROR_ARGUMENT, "medium.g[%d]: %g is outside (-1, 1)", c, (double)def->g[c]);
    return result == TY_OK ? check_bounds(context, def) : result;
}

/* The map from where bounds are the cube [-1, 1]^3 or the unit sphere to the medium's local space. */
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

/* The map from a grid's index space to the medium's local space. */
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

ty_medium_view ty_medium_get_view(const ty_medium_def* def) {
    ty_medium_view view;
    memset(&view, 0, sizeof view);
    view.bounds = (int32_t)def->bounds;
    if (def->bounds != TY_BOUNDS_NONE) {
        const ty_affine local = bounds_to_local(def);
        const ty_affine world = ty_affine_multiply(&def->transform, &local);
        invert_to_floats(&world, view.to_bounds);
    }
    if (def->density_grid != NULL) {
        const ty_grid_info info = ty_grid_get_info(def->density_grid);
        const ty_affine local = index_to_local(def, &info);
        const ty_affine world = ty_affine_multiply(&def->transform, &local);
        view.has_grid = 1;
        view.grid = ty_grid_get_view(def->density_grid);
        invert_to_floats(&world, view.to_index);
    }
    view.gray = 1;
    for (int c = 0; c < 3; ++c) {
        view.sigma_s[c] = def->scale * def->sigma_s[c];
        view.sigma_t[c] = def->scale * (def->sigma_s[c] + def->sigma_a[c]);
        view.sigma_t_max = ty_maxf(view.sigma_t_max, view.sigma_t[c]);
        view.g[c] = def->g[c];
        if (view.sigma_s[c] != view.sigma_s[0] || view.sigma_t[c] != view.sigma_t[0] || view.g[c] != view.g[0])
            view.gray = 0;
    }
    return view;
}

void ty_medium_extent(const ty_medium_def* def, double lower[3], double upper[3]) {
    ty_affine local;
    double low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    if (def->bounds != TY_BOUNDS_NONE) {
        local = bounds_to_local(def);
    } else {
        const ty_grid_info info = ty_grid_get_info(def->density_grid);
        local = info.index_to_local;
        for (int a = 0; a < 3; ++a) high[a] = info.size[a];
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
