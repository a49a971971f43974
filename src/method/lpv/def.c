/* Options: their defaults and their checks. */
#include "base/context.h"
#include "image/march.h"
#include "method/lpv/job.h"
#include "scene/check.h"
#include "scene/settings.h"

ty_lpv_def ty_lpv_def_of(const ty_lpv_settings* settings) {
    static const char* const modes[] = {"links", "published"};
    static const char* const places[] = {"scene", "camera"};
    static const char* const parts_words[] = {"all", "shadow_map", "plain", "plain_march", "single", "both"};
    static const uint32_t parts[] = {TY_LPV_ALL,    0,
                                     TY_LPV_PLAIN,  TY_LPV_PLAIN | TY_LPV_MARCH,
                                     TY_LPV_SINGLE, TY_LPV_PLAIN | TY_LPV_MARCH | TY_LPV_SINGLE};
    ty_lpv_def def = {.cookie = TY_DEF_COOKIE};
    def.mode = (ty_lpv_mode)ty_setting_index(settings->mode, modes, 2);
    def.parts = parts[ty_setting_index(settings->parts, parts_words, sizeof parts / sizeof parts[0])];
    def.place = (ty_lpv_place)ty_setting_index(settings->place, places, 2);
    def.resolution = settings->resolution;
    def.extent = settings->extent;
    def.cascades = settings->cascades;
    def.bands = settings->bands;
    def.window = settings->window;
    def.iterations = settings->iterations;
    def.tolerance = settings->tolerance;
    def.map_side = settings->map_side;
    def.samples = settings->samples;
    def.block_side = settings->block_side;
    def.shadow_side = settings->shadow_side;
    def.shadow_rays = settings->shadow_rays;
    def.half = settings->half;
    def.step = settings->step;
    def.spp = settings->spp;
    return def;
}

ty_lpv_view_def ty_default_lpv_view_def(void) {
    return (ty_lpv_view_def){.cookie = TY_DEF_COOKIE};
}

ty_lpv_def ty_default_lpv_def(void) {
    return ty_lpv_def_of(&ty_default_settings.lpv);
}

static ty_result check_lattice(ty_context* context, const ty_lpv_def* def) {
    ty_result result = ty_check_number(context, "lpv.mode", (double)def->mode, 0, 1);
    if (result == TY_OK && (def->parts & ~(uint32_t)TY_LPV_ALL) != 0)
        result = ty_fail(context, TY_ERROR_ARGUMENT, "lpv.parts: 0x%x has parts that do not exist", def->parts);
    if (result == TY_OK) result = ty_check_number(context, "lpv.resolution", def->resolution, 4, TY_LPV_CELLS_MAX);
    if (result == TY_OK) result = ty_check_number(context, "lpv.place", (double)def->place, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "lpv.extent", def->extent, 1e-6, 1e9);
    if (result == TY_OK) result = ty_check_number(context, "lpv.cascades", def->cascades, 1, TY_LPV_CASCADES_MAX);
    if (result == TY_OK) result = ty_check_number(context, "lpv.bands", def->bands, 2, TY_LPV_BANDS_MAX);
    if (result == TY_OK && def->window != -1) result = ty_check_number(context, "lpv.window", def->window, 0, 1);
    if (result == TY_OK) result = ty_check_number(context, "lpv.iterations", def->iterations, 0, 4096);
    if (result == TY_OK) result = ty_check_within(context, "lpv.tolerance", def->tolerance, 0, 1);
    return result;
}

static ty_result check_injection(ty_context* context, const ty_lpv_def* def) {
    ty_result result = ty_check_number(context, "lpv.map_side", def->map_side, 16, 4096);
    if (result == TY_OK) result = ty_check_number(context, "lpv.samples", def->samples, 1, 64);
    if (result == TY_OK) result = ty_check_number(context, "lpv.block_side", def->block_side, 1, 16);
    if (result == TY_OK) result = ty_check_number(context, "lpv.shadow_side", def->shadow_side, 16, 4096);
    return result;
}

static ty_result check_image(ty_context* context, const ty_lpv_def* def) {
    const ty_image_options options = {def->width, def->height, def->spp, def->seed, def->step, def->aovs};
    ty_result result = ty_check_image(context, "lpv", &options, TY_MARCH_AOVS | TY_AOV_NORMAL);
    if (result == TY_OK && def->view != NULL) result = ty_check_def(context, def->view, "ty_default_lpv_view_def");
    if (result == TY_OK && def->view != NULL &&
        (def->view->distance == NULL || def->view->normal == NULL || def->view->albedo == NULL))
        return ty_fail(context, TY_ERROR_ARGUMENT, "lpv.view: distance, normal and albedo must all be there");
    return result;
}

ty_result ty_lpv_check(ty_context* context, const ty_lpv_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_lpv_def");
    if (result == TY_OK) result = check_lattice(context, def);
    if (result == TY_OK) result = check_injection(context, def);
    if (result == TY_OK) result = check_image(context, def);
    return result;
}

static const char* name_of_kind(ty_light_kind kind) {
    return kind == TY_LIGHT_AREA ? "an area light" : "an environment";
}

ty_result ty_lpv_check_scene(const ty_scene* scene) {
    for (size_t i = 0; i < scene->light_count; ++i) {
        const ty_light_kind kind = scene->lights[i].kind;
        if (kind == TY_LIGHT_AREA || kind == TY_LIGHT_ENVIRONMENT)
            return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                           "lpv: lights[%zu] is %s; directional, spot and point lights are all that it takes", i,
                           name_of_kind(kind));
    }
    if (scene->light_count == 0 && ty_scene_get_info(scene).emitters > 0)
        return ty_fail(
            scene->context, TY_ERROR_ARGUMENT,
            "lpv: all light comes from surfaces that glow; directional, spot and point lights are all that it "
            "takes");
    return TY_OK;
}

ty_result ty_lpv_check_maps(const ty_scene* scene, const ty_lpv_def* def) {
    if (def->maps == NULL) return TY_OK;
    if (def->map_count < 0 || (size_t)def->map_count != scene->light_count)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "lpv.maps: %d maps for %zu lights", def->map_count,
                       scene->light_count);
    for (int32_t i = 0; i < def->map_count; ++i) {
        const ty_result result = ty_light_map_check(scene->context, &scene->view.lights.lights[i], &def->maps[i], i);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}
