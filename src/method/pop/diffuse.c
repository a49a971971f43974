/* Split mode: what turns aside of all light, and its diffusion. */
#include "base/context.h"
#include "direct/turned.h"
#include "method/pop/job.h"

/* Adds what turns aside of the ordinates' light. */
static void turn_aside(ty_pop_job* job) {
    const ty_grid_medium* medium = job->medium;
    for (int32_t c = 0; c < 3; ++c) {
        const int32_t plane = medium->planes == 3 ? c : 0;
        const float* fluence = job->light->merged.fluence[c];
        for (size_t i = 0; i < medium->cells; ++i)
            job->source[c][i] += fluence[i] * ty_turned_coefficient(medium->scattering[plane][i], medium->g[plane][i]);
    }
}

ty_result ty_pop_diffuse(ty_pop_job* job) {
    ty_diffusion_def def = ty_default_diffusion_def();
    ty_diffuse_stats stats = {.converged = false};
    const double begun = ty_wall_seconds();
    def.streaming = job->def->streaming;
    def.tolerance = job->def->tolerance;
    turn_aside(job);
    const ty_result result =
        ty_diffuse_light_solve(&def, true, job->medium, job->source, &job->progress, &job->light->diffuse, &stats);
    job->stats.residuum_seconds = ty_wall_seconds() - begun;
    job->stats.converged = stats.converged;
    for (int c = 0; c < 3; ++c)
        if (stats.iterations[c] > job->stats.iterations) job->stats.iterations = stats.iterations[c];
    return result;
}
