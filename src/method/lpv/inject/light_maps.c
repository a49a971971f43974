/* The lights' reflective shadow maps, traced or a caller's. */
#include "base/context.h"
#include "method/lpv/inject/inject.h"
#include "scene/lights/light.h"

/* Traces the map of one light over the coarsest cascade. */
static ty_result trace(ty_lpv_job* job, int32_t index, int32_t side, bool reflective, ty_rsm** out) {
    const ty_grid_box* box = &job->light->lattices[job->light->count - 1]->box;
    const ty_rsm_def def = {.side = side, .reflective = reflective, .lower = box->lower, .upper = box->upper};
    return ty_rsm_trace(job->scene, &def, index, out, &job->counter);
}

/* Texels along a side: the six faces of a point light share the number of texels of one face. */
static int32_t side_of(const ty_light_view* light, int32_t side) {
    return light->kind == TY_KIND_POINT ? side * 2 / 5 + 1 : side;
}

static bool has_map(const ty_light_def* light) {
    return !ty_light_is_surface(light) && light->kind != TY_LIGHT_ENVIRONMENT;
}

/* index: of the light among the committed ones; map: the caller's, or NULL. */
static ty_result find_map(ty_lpv_job* job, int32_t index, const ty_rsm* map, ty_lpv_light* maps) {
    const double begun = ty_wall_seconds();
    double traced = begun;
    ty_result result = TY_OK;
    maps->light = &ty_scene_get_view(job->scene)->lights.lights[index];
    if (map != NULL) {
        maps->rsm = maps->shadow_map = map;
    } else {
        const int32_t side = side_of(maps->light, job->def->map_side);
        const int32_t shadow_map = side_of(maps->light, job->def->shadow_side);
        const bool own_shadow_map = (job->def->parts & TY_LPV_SINGLE) != 0 && shadow_map > side;
        result = trace(job, index, side, true, &maps->own_rsm);
        traced = ty_wall_seconds();
        if (result == TY_OK && own_shadow_map) result = trace(job, index, shadow_map, false, &maps->own_shadow_map);
        maps->rsm = maps->own_rsm;
        maps->shadow_map = own_shadow_map ? maps->own_shadow_map : maps->own_rsm;
    }
    if (result == TY_OK)
        result = ty_shadow_hierarchy_create(job->context, maps->light, maps->shadow_map, &maps->hierarchy);
    job->stats.map_seconds += traced - begun;
    job->stats.shadow_seconds += ty_wall_seconds() - traced;
    return result;
}

ty_result ty_lpv_find_maps(ty_lpv_job* job) {
    const ty_scene* scene = job->scene;
    const size_t count = scene->light_count;
    ty_lpv* light = job->light;
    light->sources = ty_alloc_array(job->context, count, sizeof *light->sources, true);
    light->source_capacity = count;
    if (light->sources == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    int32_t committed = 0; /* lights that are surfaces are committed after all others */
    for (size_t i = 0; i < count && result == TY_OK; ++i) {
        if (has_map(&scene->lights[i]))
            result = find_map(job, committed, job->def->maps != NULL ? &job->def->maps[i] : NULL,
                              &light->sources[light->source_count++]);
        committed += !ty_light_is_surface(&scene->lights[i]);
    }
    return result;
}

void ty_lpv_free_maps(ty_lpv* light) {
    for (int32_t i = 0; i < light->source_count; ++i) {
        ty_shadow_hierarchy_destroy(light->sources[i].hierarchy);
        ty_rsm_destroy(light->context, light->sources[i].own_rsm);
        ty_rsm_destroy(light->context, light->sources[i].own_shadow_map);
    }
    ty_free_array(light->context, light->sources, light->source_capacity, sizeof *light->sources);
}
