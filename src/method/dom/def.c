/* Options: their defaults and their checks. */
#include "base/context.h"
#include "method/dom/job.h"
#include "scene/check.h"

ty_dom_def ty_default_dom_def(void) {
    return (ty_dom_def){.cookie = TY_DEF_COOKIE,
                        .directions = 96,
                        .tolerance = 1e-3,
                        .environment_beams = 64,
                        .surface_points = 16,
                        .spp = 1,
                        .step = 1};
}

/* 0 for the method's own choice, or a number in a range. */
static ty_result check_choice(ty_context* context, const char* field, double value, double low, double high) {
    return value == 0 ? TY_OK : ty_check_number(context, field, value, low, high);
}

static ty_result check_solve(ty_context* context, const ty_dom_def* def) {
    ty_result result = check_choice(context, "dom.resolution", def->resolution, 4, TY_DOM_CELLS_MAX);
    if (result == TY_OK) result = check_choice(context, "dom.direct", def->direct, 4, 1024);
    if (result == TY_OK) result = ty_check_number(context, "dom.directions", def->directions, 8, TY_DOM_DIRECTIONS_MAX);
    if (result == TY_OK) result = check_choice(context, "dom.bands", def->bands, 1, TY_DOM_BANDS_MAX);
    if (result == TY_OK) result = ty_check_number(context, "dom.acceleration", (double)def->acceleration, 0, 1);
    if (result == TY_OK && !(def->tolerance > 0 && def->tolerance < 1))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "dom.tolerance: %g is outside (0, 1)", def->tolerance);
    if (result == TY_OK) result = ty_check_number(context, "dom.iterations", def->iterations, 0, INT32_MAX);
    if (result == TY_OK) result = ty_check_number(context, "dom.environment_beams", def->environment_beams, 1, 65536);
    if (result == TY_OK) result = ty_check_number(context, "dom.surface_points", def->surface_points, 1, 65536);
    return result;
}

static ty_result check_image(ty_context* context, const ty_dom_def* def) {
    static const uint32_t known = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH;
    ty_result result = ty_check_number(context, "dom.spp", def->spp, 1, 64);
    if (result == TY_OK) result = ty_check_number(context, "dom.step", def->step, 0.05, 8);
    if (result == TY_OK && (def->aovs & ~known) != 0)
        result = ty_fail(context, TY_ERROR_ARGUMENT, "dom.aovs: transmittance, single, multiple and depth are all");
    if (result == TY_OK && ((def->width == 0) != (def->height == 0) || def->width < 0 || def->height < 0 ||
                            def->width > 65536 || def->height > 65536))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "dom: %d x %d is not a resolution in 1..65536", def->width,
                         def->height);
    return result;
}

ty_result ty_dom_check(ty_context* context, const ty_dom_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_dom_def");
    if (result == TY_OK) result = check_solve(context, def);
    if (result == TY_OK) result = check_image(context, def);
    return result;
}
