/* Options: their defaults and their checks. */
#include "base/context.h"
#include "method/pop/job.h"
#include "scene/check.h"

ty_pop_def ty_default_pop_def(void) {
    return (ty_pop_def){.cookie = TY_DEF_COOKIE,
                        .sharp = true,
                        .ordinates = 64,
                        .prefilter = 1,
                        .importance = true,
                        .surface_points = 16,
                        .vpls = 64,
                        .shadow_texels = 128,
                        .clamp = 0.05,
                        .residuum = 0.1,
                        .tolerance = 1e-2,
                        .spp = 1,
                        .step = 1};
}

/* 0 for the method's own choice, or a number in a range. */
static ty_result check_choice(ty_context* context, const char* field, double value, double low, double high) {
    return value == 0 ? TY_OK : ty_check_number(context, field, value, low, high);
}

static ty_result check_cells(ty_context* context, const ty_pop_def* def) {
    ty_result result = ty_check_number(context, "pop.mode", (double)def->mode, 0, 2);
    if (result == TY_OK) result = check_choice(context, "pop.resolution", def->resolution, 4, TY_POP_CELLS_MAX);
    if (result == TY_OK) result = check_choice(context, "pop.merged", def->merged, 4, 512);
    if (result == TY_OK) result = check_choice(context, "pop.direct", def->direct, 4, 1024);
    return result;
}

static ty_result check_lights(ty_context* context, const ty_pop_def* def) {
    ty_result result = ty_check_number(context, "pop.ordinates", def->ordinates, 1, 4096);
    if (result == TY_OK) result = ty_check_number(context, "pop.prefilter", def->prefilter, 0, 16);
    if (result == TY_OK) result = ty_check_number(context, "pop.surface_points", def->surface_points, 1, 65536);
    if (result == TY_OK) result = ty_check_number(context, "pop.vpls", def->vpls, 0, 4096);
    if (result == TY_OK) result = ty_check_number(context, "pop.shadow_texels", def->shadow_texels, 16, 1024);
    if (result == TY_OK) result = ty_check_number(context, "pop.clamp", def->clamp, 0, 1);
    return result;
}

static ty_result check_solve(ty_context* context, const ty_pop_def* def) {
    ty_result result = check_choice(context, "pop.iterations", def->iterations, 1, 10000);
    if (result == TY_OK) result = ty_check_number(context, "pop.residuum", def->residuum, 0, 1);
    if (result == TY_OK) result = check_choice(context, "pop.residuum_iterations", def->residuum_iterations, 1, 10000);
    if (result == TY_OK && !(def->streaming >= 0 && def->streaming <= 1))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "pop.streaming: %g is outside [0, 1]", def->streaming);
    if (result == TY_OK && !(def->tolerance > 0 && def->tolerance < 1))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "pop.tolerance: %g is outside (0, 1)", def->tolerance);
    return result;
}

static ty_result check_image(ty_context* context, const ty_pop_def* def) {
    static const uint32_t known = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH;
    ty_result result = ty_check_number(context, "pop.spp", def->spp, 1, 64);
    if (result == TY_OK) result = ty_check_number(context, "pop.step", def->step, 0.05, 8);
    if (result == TY_OK && (def->aovs & ~known) != 0)
        result = ty_fail(context, TY_ERROR_ARGUMENT, "pop.aovs: transmittance, single, multiple and depth are all");
    if (result == TY_OK && ((def->width == 0) != (def->height == 0) || def->width < 0 || def->height < 0 ||
                            def->width > 65536 || def->height > 65536))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "pop: %d x %d is not a resolution in 1..65536", def->width,
                         def->height);
    return result;
}

ty_result ty_pop_check(ty_context* context, const ty_pop_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_pop_def");
    if (result == TY_OK) result = check_cells(context, def);
    if (result == TY_OK) result = check_lights(context, def);
    if (result == TY_OK) result = check_solve(context, def);
    if (result == TY_OK) result = check_image(context, def);
    return result;
}
