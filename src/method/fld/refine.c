/* Refinement of coarse diffusion: sub-cell detail converges in a few sweeps of Algorithm 1 (Koerner 2014) on cells of
 * half the size, with the coefficients of those cells. */
#include "method/fld/job.h"

#include "base/context.h"
#include "scene/scene.h"

/* Cells per coarse cell along a side; number of sweeps (more gain little) and their omega. */
enum { FINER = 2, SWEEPS = 6 };
static const double OMEGA = 1.5;
/* Ratio of direct light cells to diffusion cells up to which refinement does not pay. Surfaces are between cells of
 * diffusion alone. */
static const double FINE_ENOUGH = 3;

static ty_result relax(ty_fld_job* job, const ty_grid_medium* medium, float* const source[3]) {
    ty_diffuse_light *light = NULL, *before = job->light->diffuse;
    ty_diffuse_stats ignored = {.converged = false};
    ty_diffusion_def def = ty_fld_diffusion_def(job);
    def.solver = TY_DIFFUSION_SOR;
    def.relaxation = OMEGA;
    def.iterations = SWEEPS;
    ty_incident_flux incident = {.scattered = false};
    ty_result result = TY_OK;
    if (job->light->cache != NULL)
        result =
            ty_incident_flux_make(job->light->cache, job->context, TY_REFLECTED_LAMPS, medium->box.size, &incident);
    if (result == TY_OK)
        result =
            ty_diffuse_light_refine(before, &def, job->def->beam == TY_FLD_BEAM_REDUCED, medium, source,
                                    job->light->cache != NULL ? &incident : NULL, &job->progress, &light, &ignored);
    ty_incident_flux_free(job->context, medium->box.size, &incident);
    if (result != TY_OK) return result;
    ty_diffuse_light_destroy(before);
    job->light->diffuse = light;
    return TY_OK;
}

ty_result ty_fld_refine(ty_fld_job* job) {
    if (job->def->ratio <= FINE_ENOUGH || job->light->diffuse->faces != NULL) return TY_OK;
    int32_t size[3];
    for (int a = 0; a < 3; ++a) {
        const int32_t limit = job->fine->box.size[a], finer = FINER * job->coarse->box.size[a];
        size[a] = finer < limit ? finer : limit;
    }
    ty_grid_medium* medium = NULL;
    float* source[3] = {NULL, NULL, NULL};
    ty_result result = ty_grid_medium_resize(job->fine, size, &medium);
    if (result != TY_OK) return result;
    result = ty_fld_find_sources(job, medium, source);
    if (result == TY_OK) result = relax(job, medium, source);
    for (int c = 0; c < 3; ++c) ty_free_array(job->context, source[c], medium->cells, sizeof(float));
    ty_grid_medium_destroy(medium);
    return result;
}
