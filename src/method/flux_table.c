/* Tables of fluxes by columns: checks of what is asked for, their memory, their values. */
#include "method/flux_table.h"

#include "base/check.h"
#include "base/context.h"
#include "scene/media/medium.h"

#include <math.h>
#include <string.h>

enum { COLUMNS_MAX = 65536 };

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

ty_result ty_flux_check(ty_context* context, const ty_flux_def* def) {
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

ty_result ty_flux_place_columns(const ty_scene* scene, ty_flux_def* def) {
    const ty_periodic_view* cell = &scene->view.periodic;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    const int32_t axes[2] = {0, scene->up == TY_AXIS_Z ? 1 : 2};
    for (size_t i = 0; i < scene->medium_count; ++i) ty_medium_voxel_extent(&scene->media[i], lower, upper);
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
    }
    return TY_OK;
}

ty_result ty_flux_create(ty_context* context, const ty_flux_def* def, ty_flux** out) {
    ty_flux* flux = ty_alloc_array(context, 1, sizeof *flux, true);
    if (flux == NULL) return TY_ERROR_MEMORY;
    flux->context = context;
    flux->def = *def;
    flux->columns = (int64_t)def->columns[0] * def->columns[1];
    flux->numbers = flux->columns * (TY_FLUX_LEVEL_QUANTITIES * (int64_t)def->level_count + 1 + def->view_count);
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
    int32_t number = TY_FLUX_LEVEL_QUANTITIES * index + (int32_t)quantity;
    if (quantity == TY_FLUX_ABSORBED) number = TY_FLUX_LEVEL_QUANTITIES * levels;
    if (quantity == TY_FLUX_RADIANCE) number = TY_FLUX_LEVEL_QUANTITIES * levels + 1 + index;
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
