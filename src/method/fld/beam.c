/* Uncollided light and its scattering source for diffusion: q of Eq. 6 (Koerner 2014), with the reduced beam by default
 * or as published. */
#include "method/fld/job.h"

#include "base/context.h"
#include "direct/uncollided/light_groups.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/first_collision_source.h"

ty_result ty_fld_find_sources(ty_fld_job* job, const ty_grid_medium* medium, float* source[3]) {
    float* fine = ty_alloc_array(job->context, job->fine->cells, sizeof *fine, false);
    if (fine == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c) {
        source[c] = ty_alloc_array(job->context, medium->cells, sizeof(float), false);
        if (source[c] == NULL) {
            result = TY_ERROR_MEMORY;
            break;
        }
        ty_first_collision_source(job->fine, job->light->lights, job->light->light_count, c,
                                  job->def->beam == TY_FLD_BEAM_REDUCED, fine);
        ty_grid_average(job->context, fine, job->fine->box.size, medium->box.size, source[c]);
    }
    ty_free_array(job->context, fine, job->fine->cells, sizeof *fine);
    return result;
}

/* Surfaces between coarse cells; removes the source that leaks through them from fine cells. */
static ty_result light_surfaces(ty_fld_job* job) {
    ty_result result = ty_diffuse_surfaces_find(job->scene, job->coarse, &job->surfaces);
    if (result == TY_OK)
        result = ty_diffuse_surfaces_light(job->scene, job->coarse, job->def->beam == TY_FLD_BEAM_REDUCED,
                                           &job->sources, &job->surfaces);
    if (result == TY_OK)
        result = ty_diffuse_surfaces_correct_source(&job->surfaces, job->coarse, &job->fine->box, job->light->lights,
                                                    job->light->light_count, job->source);
    return result;
}

/* q_ri of Eq. 6 (Koerner 2014). */
ty_result ty_fld_direct_light(ty_fld_job* job) {
    const ty_discretize_def def = {
        .environment = job->def->environment_beams, .surface = job->def->surface_points, .seed = job->def->seed};
    const ty_grid_medium* fine = job->fine;
    float* extinction[3] = {0};
    ty_result result = ty_discretize_lights(job->scene, &def, &job->sources);
    for (int32_t p = 0; p < fine->planes && result == TY_OK; ++p) {
        extinction[p] = ty_alloc_array(job->context, fine->cells, sizeof(float), false);
        if (extinction[p] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) ty_scaled_extinction(fine, job->def->beam == TY_FLD_BEAM_REDUCED ? 1 : 0, extinction);
    if (result == TY_OK)
        result = ty_light_groups_solve(job->scene, fine, extinction, &job->sources, TY_FLD_DEDICATED_FIELDS_MAX,
                                       &job->progress, job->light->beam, job->light->lights, &job->light->light_count);
    for (int32_t p = 0; p < fine->planes; ++p) ty_free_array(job->context, extinction[p], fine->cells, sizeof(float));
    if (result == TY_OK) result = ty_fld_find_sources(job, job->coarse, job->source);
    if (result == TY_OK) result = light_surfaces(job);
    return result == TY_OK ? ty_fld_light_outside(job) : result;
}
