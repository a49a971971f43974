/* Split mode: the diffusion source from all light, and its diffusion. */
#include "base/context.h"
#include "direct/lights/interior_light.h"
#include "direct/uncollided/first_collision_source.h"
#include "method/pop/job.h"

/* Adds the reduced scattering of the ordinates' light and the delta-Eddington sources of beams. */
static void add_source(ty_pop_job* job) {
    const ty_grid_medium* medium = job->medium;
    for (int32_t c = 0; c < 3; ++c) {
        const int32_t plane = medium->planes == 3 ? c : 0;
        const float* fluence = job->light->merged.fluence[c];
        for (size_t i = 0; i < medium->cells; ++i)
            job->source[c][i] += fluence[i] * ty_reduced_scattering(medium->scattering[plane][i], medium->g[plane][i]);
        for (size_t i = 0; i < job->delta_source.cells; ++i) job->source[c][i] += job->delta_source.arrays[c][0][i];
    }
}

/* Default max flux fraction for light sources outside the box. */
static const double max_flux_outside = 0.5;

static double default_max_flux(const ty_pop* light, const ty_diffuse_surfaces* surfaces) {
    const ty_grid_box* box = &light->merged.box;
    ty_interior_light sum = {0, 0};
    for (int32_t i = 0; i < light->light_count; ++i) {
        const ty_discrete_light* source = &light->lights[i].sample;
        if (source->kind == TY_DISCRETE_DIRECTIONAL)
            ty_interior_light_add_directional(&sum, box, source->direction, source->color);
        else
            ty_interior_light_add_point(&sum, box, source->position, source->color);
    }
    for (int32_t i = 0; i < light->count; ++i) {
        const ty_discrete_light* ordinate = &light->ordinates[i].ordinate;
        if (ordinate->kind == TY_DISCRETE_DIRECTIONAL)
            ty_interior_light_add_directional(&sum, box, ordinate->direction, ordinate->color);
        else
            ty_interior_light_add_point(&sum, box, ordinate->position, ordinate->color);
    }
    const double fraction = ty_interior_light_max_flux(&sum, max_flux_outside);
    return fraction * ty_diffuse_surfaces_flux_factor(surfaces);
}

/* Lights the surfaces between merged cells by all lights, and removes the source that leaks through them. */
static ty_result light_surfaces(ty_pop_job* job, const ty_discrete_light_set* sources) {
    const ty_pop* light = job->light;
    if (job->surfaces.faces == NULL) return TY_OK;
    const ty_result result = ty_diffuse_surfaces_light(job->scene, job->medium, true, sources, &job->surfaces);
    return result != TY_OK ? result
                           : ty_diffuse_surfaces_correct_source(&job->surfaces, job->medium, &light->fine_box,
                                                                light->lights, light->light_count, job->source);
}

/* Lights surfaces inside of the box and outside of it. */
static ty_result light_all_surfaces(ty_pop_job* job) {
    const ty_pop* light = job->light;
    ty_discrete_light_set sources;
    if (ty_scene_get_view(job->scene)->mesh == NULL) return TY_OK;
    ty_result result =
        ty_discrete_light_set_create(job->context, "pop", (int64_t)light->light_count + light->count, &sources);
    if (result != TY_OK) return result;
    for (int32_t i = 0; i < light->light_count; ++i) sources.items[sources.count++] = light->lights[i].sample;
    for (int32_t i = 0; i < light->count; ++i) sources.items[sources.count++] = light->ordinates[i].ordinate;
    result = light_surfaces(job, &sources);
    if (result == TY_OK) result = ty_pop_light_outside(job, &sources);
    ty_discrete_light_set_destroy(job->context, &sources);
    return result;
}

ty_result ty_pop_diffuse(ty_pop_job* job) {
    ty_diffusion_def def = ty_default_diffusion_def();
    ty_diffuse_stats stats = {.converged = false};
    const double begun = ty_wall_seconds();
    def.tolerance = job->def->tolerance;
    add_source(job);
    ty_result result = light_all_surfaces(job);
    if (result != TY_OK) return result;
    def.streaming =
        job->def->max_flux_fraction > 0 ? job->def->max_flux_fraction : default_max_flux(job->light, &job->surfaces);
    if (result == TY_OK)
        result = ty_diffuse_light_solve_between(&def, true, job->medium, &job->surfaces, job->source,
                                                job->light->cache != NULL ? &job->incident : NULL, &job->progress,
                                                &job->light->diffuse, &stats);
    if (result == TY_OK) ty_pop_delta_source_add_fluence(&job->delta_source, job->light->diffuse);
    if (result == TY_OK) result = ty_pop_interreflect(job, &def, &stats);
    job->stats.residuum_seconds = ty_wall_seconds() - begun;
    job->stats.converged = stats.converged;
    for (int c = 0; c < 3; ++c)
        if (stats.iterations[c] > job->stats.iterations) job->stats.iterations = stats.iterations[c];
    return result;
}
