/* Options of the method: defaults and range checks. */
#include "base/context.h"
#include "image/march.h"
#include "method/pop/job.h"
#include "scene/check.h"
#include "scene/settings.h"

ty_pop_def ty_pop_def_of(const ty_pop_settings* settings) {
    static const char* const modes[] = {"split", "published", "collided"};
    ty_pop_def def = {.cookie = TY_DEF_COOKIE};
    def.mode = (ty_pop_mode)ty_setting_index(settings->mode, modes, 3);
    def.resolution = settings->resolution;
    def.merged = settings->merged;
    def.sharp = settings->sharp;
    def.direct = settings->direct;
    def.ordinates = settings->ordinates;
    def.prefilter = settings->prefilter;
    def.importance = settings->importance;
    def.surface_points = settings->surface_points;
    def.vpls = settings->vpls;
    def.shadow_texels = settings->shadow_texels;
    def.clamp = settings->clamp;
    def.iterations = settings->iterations;
    def.residuum = settings->residuum;
    def.residuum_iterations = settings->residuum_iterations;
    def.streaming = settings->streaming;
    def.tolerance = settings->tolerance;
    def.spp = settings->spp;
    def.step = settings->step;
    return def;
}

ty_pop_def ty_default_pop_def(void) {
    return ty_pop_def_of(&ty_default_settings.pop);
}

static ty_result check_cells(ty_context* context, const ty_pop_def* def) {
    ty_result result = ty_check_number(context, "pop.mode", (double)def->mode, 0, 2);
    if (result == TY_OK) result = ty_check_choice(context, "pop.resolution", def->resolution, 4, TY_POP_CELLS_MAX);
    if (result == TY_OK) result = ty_check_choice(context, "pop.merged", def->merged, 4, 512);
    if (result == TY_OK) result = ty_check_choice(context, "pop.direct", def->direct, 4, 1024);
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
    ty_result result = ty_check_choice(context, "pop.iterations", def->iterations, 1, 10000);
    if (result == TY_OK) result = ty_check_number(context, "pop.residuum", def->residuum, 0, 1);
    if (result == TY_OK)
        result = ty_check_choice(context, "pop.residuum_iterations", def->residuum_iterations, 1, 10000);
    if (result == TY_OK) result = ty_check_number(context, "pop.streaming", def->streaming, 0, 1);
    if (result == TY_OK) result = ty_check_within(context, "pop.tolerance", def->tolerance, 0, 1);
    return result;
}

ty_image_options ty_pop_image_options(const ty_pop_def* def) {
    return (ty_image_options){def->width, def->height, def->spp, def->seed, def->step, def->aovs};
}

ty_result ty_pop_check(ty_context* context, const ty_pop_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_pop_def");
    if (result == TY_OK) result = check_cells(context, def);
    if (result == TY_OK) result = check_lights(context, def);
    if (result == TY_OK) result = check_solve(context, def);
    if (result != TY_OK) return result;
    const ty_image_options image = ty_pop_image_options(def);
    return ty_check_image(context, "pop", &image, TY_MARCH_AOVS);
}
