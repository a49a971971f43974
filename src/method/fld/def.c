/* Options: their defaults and their checks. */
#include "method/fld/job.h"

#include "base/context.h"
#include "image/march.h"
#include "scene/check.h"
#include "scene/settings.h"

ty_fld_def ty_fld_def_of(const ty_fld_settings* settings) {
    static const char* const limiters[] = {"none", "sum", "max", "kershaw", "larsen", "levermore_pomraning"};
    static const char* const boundaries[] = {"marshak", "dirichlet"};
    static const char* const solvers[] = {"multigrid", "sor", "sor_float"};
    static const char* const beams[] = {"reduced", "published"};
    ty_fld_def def = {.cookie = TY_DEF_COOKIE};
    def.limiter = (ty_fld_limiter)ty_setting_index(settings->limiter, limiters, 6);
    def.boundary = (ty_fld_boundary)ty_setting_index(settings->boundary, boundaries, 2);
    def.solver = (ty_fld_solver)ty_setting_index(settings->solver, solvers, 3);
    def.beam = (ty_fld_beam)ty_setting_index(settings->beam, beams, 2);
    def.larsen_power = settings->larsen_power;
    def.max_flux_fraction = settings->max_flux_fraction;
    def.relaxation = settings->relaxation;
    def.tolerance = settings->tolerance;
    def.sigma_eps = settings->sigma_eps;
    def.ratio = settings->ratio;
    def.step = settings->step;
    def.resolution = settings->resolution;
    def.iterations = settings->iterations;
    def.environment_beams = settings->environment_beams;
    def.surface_points = settings->surface_points;
    def.spp = settings->spp;
    return def;
}

ty_fld_def ty_default_fld_def(void) {
    return ty_fld_def_of(&ty_default_settings.fld);
}

static ty_result check_kind(ty_context* context, const char* field, int32_t value, int32_t count) {
    if (value >= 0 && value < count) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT, "%s: there is none with number %d", field, (int)value);
}

static ty_result check_solver(ty_context* context, const ty_fld_def* def) {
    ty_result result = check_kind(context, "fld.limiter", (int32_t)def->limiter, 6);
    if (result == TY_OK) result = check_kind(context, "fld.boundary", (int32_t)def->boundary, 2);
    if (result == TY_OK) result = check_kind(context, "fld.solver", (int32_t)def->solver, 3);
    if (result == TY_OK) result = check_kind(context, "fld.beam", (int32_t)def->beam, 2);
    if (result == TY_OK) result = ty_check_number(context, "fld.larsen_power", def->larsen_power, 1, 100);
    if (result == TY_OK) result = ty_check_number(context, "fld.sigma_eps", def->sigma_eps, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_number(context, "fld.max_flux_fraction", def->max_flux_fraction, 0, 1);
    if (result == TY_OK) result = ty_check_within(context, "fld.relaxation", def->relaxation, 0, 2);
    if (result == TY_OK) result = ty_check_within(context, "fld.tolerance", def->tolerance, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "fld.iterations", def->iterations, 0, INT32_MAX);
    return result;
}

static ty_result check_cells(ty_context* context, const ty_fld_def* def) {
    ty_result result = ty_check_choice(context, "fld.resolution", def->resolution, 4, TY_FLD_CELLS_MAX);
    if (result == TY_OK) result = ty_check_choice(context, "fld.ratio", def->ratio, 1, 64);
    if (result == TY_OK) result = ty_check_number(context, "fld.environment_beams", def->environment_beams, 1, 65536);
    if (result == TY_OK) result = ty_check_number(context, "fld.surface_points", def->surface_points, 1, 65536);
    return result;
}

ty_image_options ty_fld_image_options(const ty_fld_def* def) {
    return (ty_image_options){def->width, def->height, def->spp, def->seed, def->step, def->aovs};
}

ty_result ty_fld_check(ty_context* context, const ty_fld_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_fld_def");
    if (result == TY_OK) result = check_solver(context, def);
    if (result == TY_OK) result = check_cells(context, def);
    if (result != TY_OK) return result;
    const ty_image_options image = ty_fld_image_options(def);
    return ty_check_image(context, "fld", &image, TY_MARCH_AOVS);
}
