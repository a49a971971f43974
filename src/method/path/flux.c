/* Fluxes of columns by path tracing. */
#include "base/constants.h"
#include "base/context.h"
#include "method/flux_table.h"
#include "method/path/driver.h"
#include "scene/media/medium.h"

#include <math.h>
#include <string.h>

_Static_assert((int)TY_COLUMN_LEVEL_QUANTITIES == (int)TY_FLUX_LEVEL_QUANTITIES, "quantities of levels");

/* Levels lie above their heights by this part of the scene's height, so that those of a ground see it. */
static const double level_offset = 1e-5;

/* ---- places ---- */

static bool may_absorb(const ty_medium_def* medium) {
    return medium->sigma_a[0] > 0 || medium->sigma_a[1] > 0 || medium->sigma_a[2] > 0 ||
           medium->albedo_grid[0] != NULL || medium->transfer_albedo;
}

/* The box around all media that may absorb, m; empty without any. */
static void absorbing_box(const ty_scene* scene, double lower[3], double upper[3]) {
    for (int a = 0; a < 3; ++a) {
        lower[a] = INFINITY;
        upper[a] = -INFINITY;
    }
    for (size_t i = 0; i < scene->medium_count; ++i)
        if (may_absorb(&scene->media[i])) ty_medium_voxel_extent(&scene->media[i], lower, upper);
}

/* levels: of out, where paths start. */
static ty_result place_columns(const ty_scene* scene, ty_flux_def* def, double* levels, ty_path_columns* out) {
    double lower[3], upper[3], low[3], high[3];
    ty_scene_extent(scene, low, high);
    const int32_t up = scene->up == TY_AXIS_Z ? 2 : 1;
    const int32_t axes[3] = {0, up == 2 ? 1 : 2, up};
    memcpy(out->axis, axes, sizeof axes);
    const ty_result result = ty_flux_place_columns(scene, def);
    if (result != TY_OK) return result;
    for (int i = 0; i < 2; ++i) {
        out->size[i] = def->columns[i];
        out->lower[i] = def->lower[i];
        out->cell[i] = (def->upper[i] - def->lower[i]) / def->columns[i];
    }
    absorbing_box(scene, lower, upper);
    out->absorbing[0] = upper[up] > lower[up] ? lower[up] : 0;
    out->absorbing[1] = upper[up] > lower[up] ? upper[up] : 0;
    /* Of the scene's height, and of the rounding of the heights themselves. */
    const double rise = level_offset * (high[up] - low[up]) + 4e-7 * fmax(fabs(low[up]), fabs(high[up]));
    out->level_count = def->level_count;
    out->view_count = def->view_count;
    for (int32_t i = 0; i < def->level_count; ++i) levels[i] = def->levels[i] + rise;
    return TY_OK;
}

/* Paths go against the light. */
static void place_views(const ty_flux_def* def, const ty_path_columns* columns, double* levels, float* directions) {
    const bool z_up = columns->axis[2] == 2;
    for (int32_t i = 0; i < def->view_count; ++i) {
        const double zenith = def->views[i].zenith * (TY_PI_F64 / 180);
        const double azimuth = def->views[i].azimuth * (TY_PI_F64 / 180);
        const double east = sin(zenith) * cos(azimuth), north = sin(zenith) * sin(azimuth);
        float* direction = directions + 3 * i;
        direction[0] = (float)-east;
        direction[1] = (float)-(z_up ? north : cos(zenith));
        direction[2] = (float)-(z_up ? cos(zenith) : -north);
        levels[i] = columns->levels[def->views[i].zenith < 90 ? def->level_count - 1 : 0];
    }
}

/* ---- fluxes ---- */

/* True if sampled directions may meet light that nothing has scattered: of environments, and of surfaces, which emit in
 * no periodic scene. */
static bool has_extended_lights(const ty_scene_view* view) {
    bool extended = view->mesh != NULL && view->periodic.axes == 0;
    for (int32_t i = 0; i < view->lights.count; ++i) extended = extended || view->lights.lights[i].kind >= TY_KIND_AREA;
    return extended;
}

/* Samples all numbers. */
static ty_result sample(ty_path_run* run, const ty_scene* scene, ty_flux* flux) {
    run->stage = "flux";
    run->request.kind = TY_PATH_COLUMNS;
    run->item_count = flux->numbers;
    ty_result result = ty_path_run_begin(run, scene, false);
    if (result != TY_OK) return result;
    result = ty_path_sample(run);
    for (int64_t i = 0; i < flux->numbers; ++i)
        for (int c = 0; c < 3; ++c) {
            flux->values[3 * i + c] = ty_path_item_mean(&run->items[i], c);
            flux->errors[3 * i + c] = sqrt(ty_path_item_variance(&run->items[i], c));
        }
    ty_path_run_end(run);
    return result;
}

ty_result ty_path_flux(const ty_scene* scene, const ty_path_def* path, const ty_flux_def* def, ty_flux** out,
                       ty_path_stats* stats) {
    ty_context* context = ty_scene_context(scene);
    ty_path_run run;
    ty_path_stats own_stats;
    ty_flux_def own = ty_default_flux_def();
    ty_result result = ty_take_stats(context, stats, "ty_default_path_stats", &own_stats, sizeof own_stats);
    if (result == TY_OK) result = ty_path_prepare(scene, path, &run);
    if (result == TY_OK) result = ty_take_def(context, def, "ty_default_flux_def", &own, sizeof own);
    if (result == TY_OK) result = ty_flux_check(context, &own);
    if (result != TY_OK) return result;
    if (run.view.interior_count > 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "flux: the scene has dielectrics or panes, which fluxes leave out");
    double levels[TY_FLUX_LEVELS_MAX], view_levels[TY_FLUX_LEVELS_MAX];
    float views[3 * TY_FLUX_LEVELS_MAX];
    ty_path_columns columns = {.levels = levels, .view_levels = view_levels, .views = views};
    ty_flux* flux = NULL;
    result = place_columns(scene, &own, levels, &columns);
    if (result == TY_OK) result = ty_flux_create(context, &own, &flux);
    if (result != TY_OK) return result;
    columns.extended = has_extended_lights(&scene->view);
    place_views(&own, &columns, view_levels, views);
    run.request.columns = &columns;
    result = sample(&run, scene, flux);
    if (result != TY_OK) {
        ty_flux_destroy(flux);
        return result;
    }
    ty_give_stats(&run.stats, sizeof run.stats, stats);
    *out = flux;
    return TY_OK;
}
