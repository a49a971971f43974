/* Fluxes of columns by path tracing, and the tables that hold them. */
#include "base/check.h"
#include "base/constants.h"
#include "base/context.h"
#include "method/path/driver.h"
#include "scene/media/medium.h"

#include <tyndall/flux.h>

#include <math.h>
#include <string.h>

enum { COLUMNS_MAX = 65536 };

/* Levels lie above their heights by this part of the scene's height, so that those of a ground see it. */
static const double level_offset = 1e-5;

struct ty_flux {
    ty_context* context;
    ty_flux_def def;          /* levels and views are those below */
    double* levels;           /* def.level_count */
    ty_flux_view* views;      /* def.view_count */
    double *values, *errors;  /* quantities x columns x 3, in the order of ty_column_quantity */
    int64_t columns, numbers; /* columns, and numbers of all quantities */
};

void ty_init_flux_def(void* def, size_t bytes) {
    const ty_flux_def own = {.columns = {1, 1}};
    ty_init_def(def, bytes, &own, sizeof own);
}

/* ---- checks ---- */

static ty_result check_levels(ty_context* context, const ty_flux_def* def) {
    if (def->levels == NULL || def->level_count < 1 || def->level_count > TY_FLUX_LEVELS_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "flux.level_count: %d is outside [1, %d]", (int)def->level_count,
                       TY_FLUX_LEVELS_MAX);
    for (int32_t i = 0; i < def->level_count; ++i) {
        if (!isfinite(def->levels[i]) || fabs(def->levels[i]) > 1e9)
            return ty_fail(context, TY_ERROR_ARGUMENT, "flux.levels[%d]: %g is outside [-1e9, 1e9]", (int)i,
                           def->levels[i]);
        if (i > 0 && !(def->levels[i] > def->levels[i - 1]))
            return ty_fail(context, TY_ERROR_ARGUMENT, "flux.levels[%d]: %g is not above the level before it", (int)i,
                           def->levels[i]);
    }
    return TY_OK;
}

static ty_result check_views(ty_context* context, const ty_flux_def* def) {
    if (def->view_count < 0 || def->view_count > TY_FLUX_LEVELS_MAX || (def->view_count > 0 && def->views == NULL))
        return ty_fail(context, TY_ERROR_ARGUMENT, "flux.view_count: %d is outside [0, %d], or there are none",
                       (int)def->view_count, TY_FLUX_LEVELS_MAX);
    for (int32_t i = 0; i < def->view_count; ++i) {
        const ty_flux_view* view = &def->views[i];
        if (!(view->zenith >= 0 && view->zenith <= 180) || fabs(view->zenith - 90) < 1e-3)
            return ty_fail(context, TY_ERROR_ARGUMENT, "flux.views[%d].zenith: %g is outside [0, 180], or 90", (int)i,
                           view->zenith);
        if (!(fabs(view->azimuth) <= 1e6))
            return ty_fail(context, TY_ERROR_ARGUMENT, "flux.views[%d].azimuth: %g is outside [-1e6, 1e6]", (int)i,
                           view->azimuth);
    }
    return TY_OK;
}

static ty_result check_def(ty_context* context, const ty_flux_def* def) {
    ty_result result = check_levels(context, def);
    if (result == TY_OK) result = check_views(context, def);
    for (int i = 0; i < 2 && result == TY_OK; ++i) {
        if (def->columns[i] < 1 || def->columns[i] > COLUMNS_MAX)
            result = ty_fail(context, TY_ERROR_ARGUMENT, "flux.columns[%d]: %d is outside [1, %d]", i,
                             (int)def->columns[i], COLUMNS_MAX);
        else if (!isfinite(def->lower[i]) || !isfinite(def->upper[i]))
            result = ty_fail(context, TY_ERROR_ARGUMENT, "flux.lower[%d]: %g .. %g is no interval", i, def->lower[i],
                             def->upper[i]);
    }
    return result;
}

/* ---- places ---- */

static bool may_absorb(const ty_medium_def* medium) {
    return medium->sigma_a[0] > 0 || medium->sigma_a[1] > 0 || medium->sigma_a[2] > 0 ||
           medium->albedo_grid[0] != NULL || medium->transfer_albedo;
}

/* The box around all media, or those that may absorb, m; empty without any. */
static void media_box(const ty_scene* scene, bool absorbing, double lower[3], double upper[3]) {
    for (int a = 0; a < 3; ++a) {
        lower[a] = INFINITY;
        upper[a] = -INFINITY;
    }
    for (size_t i = 0; i < scene->medium_count; ++i)
        if (!absorbing || may_absorb(&scene->media[i])) ty_medium_voxel_extent(&scene->media[i], lower, upper);
}

/* levels: of out, where paths start. */
static ty_result place_columns(const ty_scene* scene, ty_flux_def* def, double* levels, ty_path_columns* out) {
    const ty_periodic_view* cell = &scene->view.periodic;
    double lower[3], upper[3], low[3], high[3];
    media_box(scene, false, lower, upper);
    ty_scene_extent(scene, low, high);
    const int32_t up = scene->up == TY_AXIS_Z ? 2 : 1;
    const int32_t axes[3] = {0, up == 2 ? 1 : 2, up};
    memcpy(out->axis, axes, sizeof axes);
    for (int i = 0; i < 2; ++i) {
        const int32_t a = axes[i];
        if (!(def->upper[i] > def->lower[i])) {
            const bool repeats = (cell->axes >> a & 1) != 0;
            def->lower[i] = repeats ? (double)cell->lower[a] : lower[a];
            def->upper[i] = repeats ? (double)cell->upper[a] : upper[a];
        }
        if (!(def->upper[i] > def->lower[i]) || !isfinite(def->upper[i] - def->lower[i]))
            return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                           "flux.lower[%d]: the scene has no media, so the columns' corners must be given", i);
        out->size[i] = def->columns[i];
        out->lower[i] = def->lower[i];
        out->cell[i] = (def->upper[i] - def->lower[i]) / def->columns[i];
    }
    media_box(scene, true, lower, upper);
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

static ty_result create_flux(ty_context* context, const ty_flux_def* def, ty_flux** out) {
    ty_flux* flux = ty_alloc_array(context, 1, sizeof *flux, true);
    if (flux == NULL) return TY_ERROR_MEMORY;
    flux->context = context;
    flux->def = *def;
    flux->columns = (int64_t)def->columns[0] * def->columns[1];
    flux->numbers = flux->columns * (TY_COLUMN_LEVEL_QUANTITIES * (int64_t)def->level_count + 1 + def->view_count);
    flux->levels = ty_alloc_array(context, (size_t)def->level_count, sizeof *flux->levels, false);
    flux->views = ty_alloc_array(context, (size_t)def->view_count, sizeof *flux->views, false);
    flux->values = ty_alloc_array(context, (size_t)flux->numbers, 3 * sizeof *flux->values, true);
    flux->errors = ty_alloc_array(context, (size_t)flux->numbers, 3 * sizeof *flux->errors, true);
    if (flux->levels == NULL || flux->views == NULL || flux->values == NULL || flux->errors == NULL) {
        ty_flux_destroy(flux);
        return TY_ERROR_MEMORY;
    }
    memcpy(flux->levels, def->levels, (size_t)def->level_count * sizeof *flux->levels);
    if (def->view_count > 0) memcpy(flux->views, def->views, (size_t)def->view_count * sizeof *flux->views);
    flux->def.levels = flux->levels;
    flux->def.views = def->view_count > 0 ? flux->views : NULL;
    *out = flux;
    return TY_OK;
}

void ty_flux_destroy(ty_flux* flux) {
    if (flux == NULL) return;
    ty_context* context = flux->context;
    ty_free_array(context, flux->levels, (size_t)flux->def.level_count, sizeof *flux->levels);
    ty_free_array(context, flux->views, (size_t)flux->def.view_count, sizeof *flux->views);
    ty_free_array(context, flux->values, (size_t)flux->numbers, 3 * sizeof *flux->values);
    ty_free_array(context, flux->errors, (size_t)flux->numbers, 3 * sizeof *flux->errors);
    ty_free_array(context, flux, 1, sizeof *flux);
}

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
    if (result == TY_OK) result = check_def(context, &own);
    if (result != TY_OK) return result;
    if (run.view.interior_count > 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "flux: the scene has dielectrics or panes, which fluxes leave out");
    double levels[TY_FLUX_LEVELS_MAX], view_levels[TY_FLUX_LEVELS_MAX];
    float views[3 * TY_FLUX_LEVELS_MAX];
    ty_path_columns columns = {.levels = levels, .view_levels = view_levels, .views = views};
    ty_flux* flux = NULL;
    result = place_columns(scene, &own, levels, &columns);
    if (result == TY_OK) result = create_flux(context, &own, &flux);
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

/* ---- values ---- */

void ty_flux_copy_def(const ty_flux* flux, void* out, size_t bytes) {
    ty_init_def(out, bytes, &flux->def, sizeof flux->def);
}

/* The first number of a quantity; -1 for an index past the end. */
static int64_t first_number(const ty_flux* flux, ty_flux_quantity quantity, int32_t index) {
    const int32_t levels = flux->def.level_count;
    const int32_t count = quantity == TY_FLUX_ABSORBED   ? 1
                          : quantity == TY_FLUX_RADIANCE ? flux->def.view_count
                                                         : levels;
    if (index < 0 || index >= count || quantity < TY_FLUX_UP || quantity > TY_FLUX_RADIANCE) return -1;
    int32_t number = TY_COLUMN_LEVEL_QUANTITIES * index + (int32_t)quantity;
    if (quantity == TY_FLUX_ABSORBED) number = TY_COLUMN_LEVEL_QUANTITIES * levels;
    if (quantity == TY_FLUX_RADIANCE) number = TY_COLUMN_LEVEL_QUANTITIES * levels + 1 + index;
    return number * flux->columns;
}

const double* ty_flux_values(const ty_flux* flux, ty_flux_quantity quantity, int32_t index) {
    const int64_t first = first_number(flux, quantity, index);
    return first >= 0 ? flux->values + 3 * first : NULL;
}

const double* ty_flux_errors(const ty_flux* flux, ty_flux_quantity quantity, int32_t index) {
    const int64_t first = first_number(flux, quantity, index);
    return first >= 0 ? flux->errors + 3 * first : NULL;
}

void ty_flux_mean(const ty_flux* flux, ty_flux_quantity quantity, int32_t index, double mean[3], double error[3]) {
    const int64_t first = first_number(flux, quantity, index);
    for (int c = 0; c < 3; ++c) {
        double sum = 0, squares = 0;
        for (int64_t i = first; first >= 0 && i < first + flux->columns; ++i) {
            sum += flux->values[3 * i + c];
            squares += flux->errors[3 * i + c] * flux->errors[3 * i + c];
        }
        mean[c] = sum / (double)flux->columns;
        error[c] = sqrt(squares) / (double)flux->columns;
    }
}
