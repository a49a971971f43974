/* Options: their defaults and their checks. */
#include "base/context.h"
#include "image/march.h"
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
    const ty_image_options image = ty_pop_image_options(def);
    if (result == TY_OK) result = ty_check_image(context, "pop", &image, TY_MARCH_AOVS);
    return result;
}
