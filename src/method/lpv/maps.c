/* What lights meet first: maps that are traced or a caller's. */
#include "base/context.h"
#include "method/lpv/job.h"

/* The map of one light, traced over the widest lattice. */
static ty_result trace(ty_lpv_job* job, int32_t index, int32_t side, bool reflective, ty_light_map** out) {
    const ty_grid_box* box = &job->light->lattices[job->light->count - 1]->box;
    const ty_light_map_def def = {.side = side, .reflective = reflective, .lower = box->lower, .upper = box->upper};
    return ty_light_map_trace(job->scene, &def, index, out, &job->counter);
}

/* Point lights' maps have six faces, which share as many texels as the others' one has. */
static int32_t side_of(const ty_light_view* light, int32_t side) {
    return light->kind == TY_KIND_POINT ? side * 2 / 5 + 1 : side;
}

static ty_result find_map(ty_lpv_job* job, int32_t index) {
    ty_lpv_source* source = &job->light->sources[index];
    const double begun = ty_wall_seconds();
    double traced = begun;
    ty_result result = TY_OK;
    source->light = &ty_scene_get_view(job->scene)->lights.lights[index];
    if (job->def->maps != NULL) {
        source->map = source->sharp = &job->def->maps[index];
    } else {
        const int32_t side = side_of(source->light, job->def->map_side);
        const int32_t sharp = side_of(source->light, job->def->shadow_side);
        const bool finer = (job->def->parts & TY_LPV_SINGLE) != 0 && sharp > side;
        result = trace(job, index, side, true, &source->own);
        traced = ty_wall_seconds();
        if (result == TY_OK && finer) result = trace(job, index, sharp, false, &source->finer);
        source->map = source->own;
        source->sharp = finer ? source->finer : source->own;
    }
    if (result == TY_OK) result = ty_lit_map_create(job->context, source->light, source->sharp, &source->lit);
    job->stats.map_seconds += traced - begun;
    job->stats.shadow_seconds += ty_wall_seconds() - traced;
    return result;
}

ty_result ty_lpv_find_maps(ty_lpv_job* job) {
    const size_t count = job->scene->light_count;
    job->light->sources = ty_alloc_array(job->context, count, sizeof *job->light->sources, true);
    if (job->light->sources == NULL) return TY_ERROR_MEMORY;
    job->light->source_count = (int32_t)count;
    ty_result result = TY_OK;
    for (int32_t i = 0; i < job->light->source_count && result == TY_OK; ++i) result = find_map(job, i);
    return result;
}

void ty_lpv_free_maps(ty_lpv* light) {
    for (int32_t i = 0; i < light->source_count; ++i) {
        ty_lit_map_destroy(light->sources[i].lit);
        ty_light_map_destroy(light->context, light->sources[i].own);
        ty_light_map_destroy(light->context, light->sources[i].finer);
    }
    ty_free_array(light->context, light->sources, (size_t)light->source_count, sizeof *light->sources);
}
