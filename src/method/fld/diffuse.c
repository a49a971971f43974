/* Diffuse light: solver settings from the options. */
#include "direct/lights/interior_light.h"
#include "method/fld/job.h"

#include <string.h>

/* Minimum iterations: where the cells of a point light outshine all others, the first residual is small regardless of
 * the rest. */
enum { MIN_ITERATIONS = 2 };

/* Maximum flux fraction for light from outside. */
static const double max_flux_fraction_outside = 0.55;

static void add_light(const ty_fld_job* job, const ty_discrete_light* source, const float color[3],
                      ty_interior_light* sum) {
    if (source->kind == TY_DISCRETE_DIRECTIONAL)
        ty_interior_light_add_directional(sum, &job->fine->box, source->direction, color);
    else
        ty_interior_light_add_point(sum, &job->fine->box, source->position, color);
}

static ty_interior_light sum_sources(const ty_fld_job* job) {
    ty_interior_light sum = {0, 0};
    for (int32_t i = 0; i < job->sources.count; ++i)
        add_light(job, &job->sources.items[i], job->sources.items[i].color, &sum);
    return sum;
}

static double flux_fraction_of_sources(const ty_fld_job* job) {
    const ty_interior_light sum = sum_sources(job);
    const double fraction = ty_interior_light_max_flux(&sum, max_flux_fraction_outside);
    return fraction * ty_diffuse_surfaces_flux_factor(&job->surfaces);
}

void ty_fld_return_flux_fraction(const ty_fld_job* job, double by_fraction, double (*lights)[3]) {
    const ty_interior_light sum = sum_sources(job);
    if (job->def->max_flux_fraction > 0) return;
    for (int32_t i = 0; i < job->sources.count; ++i)
        for (int c = 0; c < 3; ++c) {
            const ty_discrete_light* source = &job->sources.items[i];
            float color[3] = {0};
            ty_interior_light part = {0, 0};
            color[c] = source->color[c];
            add_light(job, source, color, &part);
            lights[source->light][c] +=
                by_fraction * ty_interior_light_max_flux_slope(&sum, &part, max_flux_fraction_outside);
        }
}

ty_diffusion_def ty_fld_diffusion_def(const ty_fld_job* job) {
    const ty_fld_def* fld = job->def;
    static const ty_limiter limiters[] = {TY_LIMITER_NONE,    TY_LIMITER_SUM,    TY_LIMITER_MAX,
                                          TY_LIMITER_KERSHAW, TY_LIMITER_LARSEN, TY_LIMITER_LEVERMORE_POMRANING};
    static const ty_boundary_kind boundaries[] = {TY_BOUNDARY_MARSHAK, TY_BOUNDARY_DIRICHLET};
    static const ty_diffusion_solver solvers[] = {TY_DIFFUSION_MULTIGRID, TY_DIFFUSION_SOR, TY_DIFFUSION_SOR_FLOAT};
    ty_diffusion_def def = ty_default_diffusion_def();
    def.min_extinction = fld->sigma_eps == TY_AUTO ? 0 : fld->sigma_eps;
    def.limiter = limiters[fld->limiter];
    def.larsen_power = fld->larsen_power;
    def.streaming = fld->max_flux_fraction > 0 ? fld->max_flux_fraction : flux_fraction_of_sources(job);
    for (int side = 0; side < 6; ++side) def.boundary[side].kind = boundaries[fld->boundary];
    def.solver = solvers[fld->solver];
    def.relaxation = fld->relaxation;
    def.tolerance = fld->tolerance;
    def.iterations = fld->iterations == TY_AUTO ? 0 : fld->iterations;
    def.min_iterations = fld->limiter != TY_FLD_LIMITER_NONE ? MIN_ITERATIONS : 0;
    return def;
}

ty_result ty_fld_diffuse(ty_fld_job* job) {
    const ty_diffusion_def def = ty_fld_diffusion_def(job);
    ty_fld_stats* stats = &job->stats;
    ty_diffuse_stats solved = {.converged = false};
    const ty_result result = ty_diffuse_light_solve_between(
        &def, job->def->beam == TY_FLD_BEAM_REDUCED, job->coarse, &job->surfaces, job->source,
        job->light->cache != NULL ? &job->incident : NULL, &job->progress, &job->light->diffuse, &solved);
    stats->converged = solved.converged;
    stats->memory_bytes = solved.bytes;
    stats->solve_ranks = solved.ranks;
    memcpy(stats->iterations, solved.iterations, sizeof stats->iterations);
    memcpy(stats->cycles, solved.cycles, sizeof stats->cycles);
    memcpy(stats->residual, solved.residual, sizeof stats->residual);
    memcpy(stats->work, solved.work, sizeof stats->work);
    memcpy(stats->emitted, solved.emitted, sizeof stats->emitted);
    memcpy(stats->absorbed, solved.absorbed, sizeof stats->absorbed);
    memcpy(stats->leaving, solved.leaving, sizeof stats->leaving);
    memcpy(stats->absorbed_by_surfaces, solved.surfaces_absorbed, sizeof stats->absorbed_by_surfaces);
    return result;
}
