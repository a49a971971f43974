/* Options, their defaults and their checks. */
#include "base/context.h"
#include "image/march.h"
#include "method/dom/job.h"
#include "scene/check.h"
#include "scene/settings.h"

ty_dom_def ty_dom_def_of(const ty_dom_settings* settings) {
    static const char* const accelerations[] = {"diffusion", "none"};
    ty_dom_def def = {.cookie = TY_DEF_COOKIE};
    def.resolution = settings->resolution;
    def.direct = settings->direct;
    def.directions = settings->directions;
    def.last_directions = settings->last_directions;
    def.bands = settings->bands;
    def.acceleration = (ty_dom_acceleration)ty_setting_index(settings->acceleration, accelerations, 2);
    def.tolerance = settings->tolerance;
    def.iterations = settings->iterations;
    def.environment_beams = settings->environment_beams;
    def.surface_points = settings->surface_points;
    def.spp = settings->spp;
    def.step = settings->step;
    return def;
}

ty_dom_def ty_default_dom_def(void) {
    return ty_dom_def_of(&ty_default_settings.dom);
}

static ty_result check_solve(ty_context* context, const ty_dom_def* def) {
    ty_result result = ty_check_choice(context, "dom.resolution", def->resolution, 4, TY_DOM_CELLS_MAX);
    if (result == TY_OK) result = ty_check_choice(context, "dom.direct", def->direct, 4, 1024);
    if (result == TY_OK) result = ty_check_number(context, "dom.directions", def->directions, 8, TY_DOM_DIRECTIONS_MAX);
    if (result == TY_OK)
        result = ty_check_choice(context, "dom.last_directions", def->last_directions, 8, TY_DOM_DIRECTIONS_MAX);
    if (result == TY_OK) result = ty_check_choice(context, "dom.bands", def->bands, 1, TY_DOM_BANDS_MAX);
    if (result == TY_OK) result = ty_check_number(context, "dom.acceleration", (double)def->acceleration, 0, 1);
    if (result == TY_OK) result = ty_check_within(context, "dom.tolerance", def->tolerance, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "dom.iterations", def->iterations, 0, INT32_MAX);
    if (result == TY_OK) result = ty_check_number(context, "dom.environment_beams", def->environment_beams, 1, 65536);
    if (result == TY_OK) result = ty_check_number(context, "dom.surface_points", def->surface_points, 1, 65536);
    return result;
}

ty_image_options ty_dom_image_options(const ty_dom_def* def) {
    return (ty_image_options){def->width, def->height, def->spp, def->seed, def->step, def->aovs};
}

ty_result ty_dom_check(ty_context* context, const ty_dom_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_dom_def");
    if (result == TY_OK) result = check_solve(context, def);
    if (result != TY_OK) return result;
    const ty_image_options image = ty_dom_image_options(def);
    return ty_check_image(context, "dom", &image, TY_MARCH_AOVS);
}
