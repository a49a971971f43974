/* Options: their defaults and their checks. */
#include "method/octaves/job.h"

#include "base/context.h"
#include "scene/check.h"

#include <math.h>

ty_octaves_def ty_default_octaves_def(void) {
    return (ty_octaves_def){.cookie = TY_DEF_COOKIE,
                            .count = 6,
                            .scattering = 0.5,
                            .extinction = 0.5,
                            .anisotropy = 0.5,
                            .environment_beams = 64,
                            .surface_points = 16,
                            .spp = 1,
                            .step = 1};
}

/* a <= b keeps the octaves of a scaled view from growing: seen through b^i sigma_t, octave i sends at most (a / b)^i
 * times the albedo (Wrenninge 2013). */
static ty_result check_scales(ty_context* context, const ty_octaves_def* def) {
    ty_result result = ty_check_number(context, "octaves.count", def->count, 1, TY_OCTAVES_COUNT_MAX);
    if (result == TY_OK) result = ty_check_number(context, "octaves.scattering", def->scattering, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "octaves.extinction", def->extinction, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "octaves.anisotropy", def->anisotropy, 0, 1);
    if (result != TY_OK) return result;
    if (def->view_extinction != TY_OCTAVES_VIEW_UNSCALED && def->view_extinction != TY_OCTAVES_VIEW_SCALED)
        return ty_fail(context, TY_ERROR_ARGUMENT, "octaves.view_extinction: there is none with number %d",
                       (int)def->view_extinction);
    if (def->view_extinction == TY_OCTAVES_VIEW_SCALED && def->scattering > def->extinction)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "octaves.scattering: %g exceeds octaves.extinction (%g), with which a scaled view gains energy",
                       def->scattering, def->extinction);
    return TY_OK;
}

static ty_result check_cells(ty_context* context, const ty_octaves_def* def) {
    ty_result result = ty_check_choice(context, "octaves.resolution", def->resolution, 4, 1024);
    if (result == TY_OK)
        result = ty_check_number(context, "octaves.environment_beams", def->environment_beams, 1, 65536);
    if (result == TY_OK) result = ty_check_number(context, "octaves.surface_points", def->surface_points, 1, 65536);
    return result;
}

ty_image_options ty_octaves_image_options(const ty_octaves_def* def) {
    return (ty_image_options){def->width, def->height, def->spp, def->seed, def->step, def->aovs};
}

ty_result ty_octaves_check(ty_context* context, const ty_octaves_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_octaves_def");
    if (result == TY_OK) result = check_scales(context, def);
    if (result == TY_OK) result = check_cells(context, def);
    if (result != TY_OK) return result;
    const ty_image_options image = ty_octaves_image_options(def);
    return ty_check_image(context, "octaves", &image, TY_MARCH_AOVS);
}

ty_march_octaves ty_octaves_of(const ty_octaves_def* def) {
    const bool scaled = def->view_extinction == TY_OCTAVES_VIEW_SCALED;
    ty_march_octaves octaves = {.count = def->count, .scales_view = scaled && def->count > 1};
    for (int32_t i = 0; i < def->count; ++i) {
        octaves.scattering[i] = (float)pow(def->scattering, i);
        octaves.extinction[i] = (float)pow(def->extinction, i);
    }
    return octaves;
}
