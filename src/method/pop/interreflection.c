/* Split mode: surfaces outside of the box, and what media and they return to one another. */
#include "base/constants.h"
#include "base/context.h"
#include "method/pop/job.h"

ty_result ty_pop_light_outside(ty_pop_job* job, const ty_discrete_light_set* sources) {
    const ty_grid_medium* medium = job->medium;
    ty_irradiance_cache** cache = &job->light->cache;
    ty_result result = ty_irradiance_cache_create(job->scene, medium, cache);
    if (result != TY_OK || *cache == NULL) return result;
    result = ty_irradiance_cache_light(*cache, job->scene, medium, sources->items, sources->count);
    if (result == TY_OK)
        result = ty_incident_flux_make(*cache, job->context, TY_REFLECTED_LAMPS, medium->box.size, &job->incident);
    return result;
}

/* Mean radiance of the ordinates' light. */
static ty_result average_ordinates(const ty_pop* light, float* out[3]) {
    for (int c = 0; c < 3; ++c) {
        out[c] = ty_alloc_array(light->context, light->cells, sizeof(float), false);
        if (out[c] == NULL) return TY_ERROR_MEMORY;
        for (size_t i = 0; i < light->cells; ++i) out[c][i] = light->merged.fluence[c][i] * TY_INV_4PI;
    }
    return TY_OK;
}

ty_result ty_pop_interreflect(ty_pop_job* job, const ty_diffusion_def* solver, const ty_diffuse_stats* solved) {
    const ty_pop* light = job->light;
    float* mean[3] = {NULL, NULL, NULL};
    ty_diffuse_stats returned;
    if (light->cache == NULL || !job->def->interreflection) return TY_OK;
    ty_interreflection_def def = {.scene = job->scene,
                                  .medium = job->medium,
                                  .solver = *solver,
                                  .reduced = true,
                                  .surfaces = &job->surfaces,
                                  .march = ty_default_march_def(),
                                  .added = light->count > 0 ? mean : NULL,
                                  .progress = &job->progress};
    ty_pop_set_march(light, &def.march);
    def.march.width = def.march.height = 1;
    def.march.step = job->def->step;
    for (int c = 0; c < 3; ++c) def.emitted += solved->emitted[c];
    ty_result result = light->count > 0 ? average_ordinates(light, mean) : TY_OK;
    if (result == TY_OK) result = ty_interreflect(&def, light->cache, light->diffuse, &returned);
    for (int c = 0; c < 3; ++c) ty_free_array(light->context, mean[c], light->cells, sizeof(float));
    return result;
}
