/* The diffuse light: what fld's options say of its solves. */
#include "direct/inside.h"
#include "method/fld/job.h"

#include <string.h>

/* Where a lamp's own cells outshine all others, the first residual is small whatever the rest is like. */
enum { LEAST_ITERATIONS = 2 };

/* Of light that comes from outside. */
static const double streaming_outside = 0.55;

static double own_streaming(const ty_fld_job* job) {
    ty_inside sum = {0, 0};
    for (int32_t i = 0; i < job->source_count; ++i) {
        const ty_source* source = &job->sources[i];
        if (source->kind == TY_SOURCE_BEAM)
            ty_inside_add_beam(&sum, &job->fine->box, source->direction, source->color);
        else
            ty_inside_add_lamp(&sum, &job->fine->box, source->position, source->color);
    }
    return ty_inside_streaming(&sum, streaming_outside);
}

ty_diffusion_def ty_fld_diffusion_def(const ty_fld_job* job) {
    const ty_fld_def* fld = job->def;
    static const ty_limiter limiters[] = {TY_LIMITER_NONE,    TY_LIMITER_SUM,    TY_LIMITER_MAX,
                                          TY_LIMITER_KERSHAW, TY_LIMITER_LARSEN, TY_LIMITER_LEVERMORE_POMRANING};
    static const ty_boundary_kind boundaries[] = {TY_BOUNDARY_MARSHAK, TY_BOUNDARY_DIRICHLET};
    static const ty_diffusion_solver solvers[] = {TY_DIFFUSION_MULTIGRID, TY_DIFFUSION_SOR, TY_DIFFUSION_SOR_FLOAT};
    ty_diffusion_def def = ty_default_diffusion_def();
    def.min_extinction = fld->sigma_eps;
    def.limiter = limiters[fld->limiter];
    def.larsen_power = fld->larsen_power;
    def.streaming = fld->streaming > 0 ? fld->streaming : own_streaming(job);
    for (int side = 0; side < 6; ++side) def.boundary[side].kind = boundaries[fld->boundary];
    def.solver = solvers[fld->solver];
    def.relaxation = fld->relaxation;
    def.tolerance = fld->tolerance;
    def.iterations = fld->iterations;
    def.min_iterations = fld->limiter != TY_FLD_LIMITER_NONE ? LEAST_ITERATIONS : 0;
    return def;
}

ty_result ty_fld_diffuse(ty_fld_job* job) {
    const ty_diffusion_def def = ty_fld_diffusion_def(job);
    ty_fld_stats* stats = &job->stats;
    ty_diffuse_stats solved = {.converged = false};
    const ty_result result = ty_diffuse_light_solve(&def, job->def->beam == TY_FLD_BEAM_REDUCED, job->coarse,
                                                    job->source, &job->progress, &job->light->diffuse, &solved);
    stats->converged = solved.converged;
    stats->bytes = solved.bytes;
    memcpy(stats->iterations, solved.iterations, sizeof stats->iterations);
    memcpy(stats->cycles, solved.cycles, sizeof stats->cycles);
    memcpy(stats->residual, solved.residual, sizeof stats->residual);
    memcpy(stats->work, solved.work, sizeof stats->work);
    memcpy(stats->emitted, solved.emitted, sizeof stats->emitted);
    memcpy(stats->absorbed, solved.absorbed, sizeof stats->absorbed);
    memcpy(stats->leaving, solved.leaving, sizeof stats->leaving);
    return result;
}
