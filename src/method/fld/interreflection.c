/* Surfaces outside of the box, and what media and they return to one another. */
#include "method/fld/job.h"

#include <string.h>

ty_result ty_fld_light_outside(ty_fld_job* job) {
    const ty_grid_medium* medium = job->coarse;
    ty_irradiance_cache** cache = &job->light->cache;
    ty_result result = ty_irradiance_cache_create(job->scene, medium, cache);
    if (result != TY_OK || *cache == NULL) return result;
    result = ty_irradiance_cache_light(*cache, job->scene, medium, job->sources.items, job->sources.count);
    if (result == TY_OK)
        result = ty_incident_flux_make(*cache, job->context, TY_REFLECTED_LAMPS, medium->box.size, &job->incident);
    return result;
}

ty_result ty_fld_interreflect(ty_fld_job* job) {
    ty_fld* light = job->light;
    ty_fld_stats* stats = &job->stats;
    ty_diffuse_stats returned;
    if (light->cache == NULL || !job->def->interreflection) return TY_OK;
    ty_interreflection_def def = {.scene = job->scene,
                                  .medium = job->coarse,
                                  .solver = ty_fld_diffusion_def(job),
                                  .reduced = light->reduced,
                                  .surfaces = &job->surfaces,
                                  .march = ty_default_march_def(),
                                  .progress = &job->progress};
    ty_fld_set_march(light, &def.march);
    def.march.width = def.march.height = 1;
    def.march.step = job->def->step;
    for (int c = 0; c < 3; ++c) def.emitted += stats->emitted[c];
    const ty_result result = ty_interreflect(&def, light->cache, light->diffuse, &returned);
    for (int c = 0; c < 3; ++c) {
        stats->absorbed[c] += returned.absorbed[c];
        stats->absorbed_by_surfaces[c] += returned.surfaces_absorbed[c];
        stats->leaving[c] += returned.leaving[c];
        stats->emitted[c] += returned.emitted[c];
    }
    return result;
}
