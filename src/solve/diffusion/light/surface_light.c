/* Light that surfaces send, and that enters the box, is carried first until it scatters out of the forward direction,
 * by diffusion without scattering from surface to surface: div(D grad phi_s) = sigma' phi_s. Its first collisions,
 * sigma_s' phi_s, are one more source of collided light, which surfaces reflect and absorb. Pictures of surfaces have
 * their unscattered light already, so collided light alone lights them, with that part of phi_s which has scattered
 * straight on: the difference to a solve with sigma_t. */
#include "solve/diffusion/light/surface_light.h"

#include "base/context.h"
#include "solve/diffusion/divided/joint.h"

#include <string.h>

/* Residual of light without scattering relative to that of collided light. */
static const double TOLERANCE = 3;
/* The flux of light of surfaces over its fluence, at most, in thin media and rooms. With less, courts that light leaves
 * are too dark: 0.87 of the light of the built-in atrium with 0.55, 0.91 with 1. */
static const double STREAMING = 1;

typedef struct surface_job {
    const ty_diffusion_def* def;
    const ty_diffuse_surfaces* surfaces;
    const ty_incident_flux* incident; /* NULL: none */
    int32_t channel;
    ty_diffuse_light* light;
    float* source;                /* of collided light */
    float* terms[TY_FIELD_TERMS]; /* of light before its first collision */
    float *side_flux, *irradiance, *unscattered_irradiance;
} surface_job;

static size_t term_size(const ty_diffuse_light* light, int term) {
    return term == 0 ? light->cells : light->cells + light->cells / (size_t)light->box.size[term - 1];
}

/* ---- light of surfaces before its first collision ---- */

static ty_result solve_absorbing(const surface_job* job, const float* extinction, const float* start, float* fluence,
                                 float* const flux[3], float* irradiance, ty_diffusion_stats* stats) {
    ty_diffusion_def def = *job->def;
    const ty_diffusion_faces faces = ty_diffuse_surfaces_faces(job->surfaces, job->channel, true);
    float* zeros = ty_alloc_array(job->light->context, job->light->cells, sizeof *zeros, true);
    if (zeros == NULL) return TY_ERROR_MEMORY;
    def.extinction = def.absorption = extinction;
    def.source = zeros;
    def.faces = &faces;
    def.start = start;
    def.tolerance = job->def->tolerance * TOLERANCE < 1 ? job->def->tolerance * TOLERANCE : job->def->tolerance;
    def.progress = NULL;
    def.streaming = STREAMING;
    const ty_diffusion_out out = {.fluence = fluence,
                                  .flux = {flux[0], flux[1], flux[2]},
                                  .side_flux = job->side_flux,
                                  .side_irradiance = irradiance};
    ty_diffusion_stats ignored;
    const ty_result result =
        ty_diffusion_solve_jointly(job->light->context, &def, &out, stats != NULL ? stats : &ignored);
    ty_free_array(job->light->context, zeros, job->light->cells, sizeof *zeros);
    return result;
}

/* Adds the first-collision source of the light of surfaces. Returns its power over the volume of a cell. */
static double add_first_collisions(const surface_job* job) {
    const ty_diffusion_def* def = job->def;
    double sum = 0;
    for (size_t i = 0; i < job->light->cells; ++i) {
        const float absorption = def->absorption != NULL ? def->absorption[i] : 0;
        const float scattered = ty_maxf(0, def->extinction[i] - absorption) * job->terms[0][i];
        job->source[i] += scattered;
        sum += (double)scattered;
    }
    return sum;
}

static ty_result carry_surface_light(const surface_job* job, const float* unscattered, ty_diffusion_stats* stats) {
    const size_t bytes = sizeof(float) * (size_t)job->surfaces->faces->count;
    const double* cell = job->def->cell;
    float* none[3] = {NULL, NULL, NULL};
    *stats = (ty_diffusion_stats){.converged = true};
    if (job->incident == NULL && ty_diffuse_surfaces_are_dark(job->surfaces, job->channel)) return TY_OK;
    ty_result result =
        solve_absorbing(job, job->def->extinction, NULL, job->terms[0], &job->terms[1], job->irradiance, stats);
    if (result != TY_OK) return result;
    if (job->incident != NULL && job->incident->scattered) {
        memset(job->unscattered_irradiance, 0, bytes);
    } else if (unscattered != NULL) {
        float* fluence = ty_alloc_array(job->light->context, job->light->cells, sizeof *fluence, false);
        surface_job straight = *job;
        straight.side_flux = NULL;
        if (fluence == NULL) return TY_ERROR_MEMORY;
        result =
            solve_absorbing(&straight, unscattered, job->terms[0], fluence, none, job->unscattered_irradiance, NULL);
        ty_free_array(job->light->context, fluence, job->light->cells, sizeof *fluence);
    } else {
        memcpy(job->unscattered_irradiance, job->irradiance, bytes);
    }
    const double scattered = add_first_collisions(job) * cell[0] * cell[1] * cell[2];
    stats->absorbed -= scattered;
    stats->surfaces_emitted -= scattered;
    ty_diffuse_terms_make(job->light->box.size, job->terms, job->surfaces->faces, job->side_flux);
    return result;
}

/* ---- collided light ---- */

/* Lets the first two moments of the cells at surfaces give their irradiance. */
static void match_sides(const surface_job* job, const float* irradiance) {
    const ty_boundary_faces* faces = job->surfaces->faces;
    const int64_t rows = (int64_t)faces->size[1] * faces->size[2];
    for (int64_t row = 0; row < rows; ++row)
        for (int32_t side = faces->first[row]; side < faces->first[row + 1]; ++side) {
            const float straight = ty_maxf(0, job->irradiance[side] - job->unscattered_irradiance[side]);
            ty_side_match_irradiance(
                &faces->sides[side], irradiance[side] + straight + job->surfaces->forward[job->channel][side],
                (size_t)row * (size_t)faces->size[0] + (size_t)faces->x[side], job->light->surface_terms[job->channel]);
        }
}

static ty_result solve_collided(const surface_job* job, ty_diffusion_stats* stats) {
    ty_diffuse_light* light = job->light;
    float* const* terms = light->terms[job->channel];
    ty_diffusion_def def = *job->def;
    const ty_diffusion_faces faces = ty_diffuse_surfaces_faces(job->surfaces, job->channel, false);
    const size_t count = (size_t)faces.count;
    float* irradiance = ty_alloc_array(light->context, count, sizeof *irradiance, true);
    if (irradiance == NULL) return TY_ERROR_MEMORY;
    def.source = job->source;
    def.faces = &faces;
    for (int side = 0; side < 6; ++side) def.boundary[side].value = NULL;
    const ty_diffusion_out out = {.fluence = terms[0],
                                  .flux = {terms[1], terms[2], terms[3]},
                                  .side_flux = job->side_flux,
                                  .side_irradiance = irradiance};
    const ty_result result = ty_diffusion_solve_jointly(light->context, &def, &out, stats);
    if (result == TY_OK) {
        ty_diffuse_terms_make(light->box.size, terms, job->surfaces->faces, job->side_flux);
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            memcpy(light->surface_terms[job->channel][t], terms[t], sizeof(float) * light->cells);
        match_sides(job, irradiance);
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            for (size_t i = 0; i < light->cells; ++i) terms[t][i] += job->terms[t][i];
    }
    ty_free_array(light->context, irradiance, count, sizeof *irradiance);
    return result;
}

static void add_stats(ty_diffusion_stats* stats, const ty_diffusion_stats* surfaces) {
    stats->converged = stats->converged && surfaces->converged;
    stats->cycles += surfaces->cycles;
    stats->work += surfaces->work;
    stats->emitted += surfaces->surfaces_emitted;
    stats->absorbed += surfaces->absorbed;
    stats->surfaces_absorbed += surfaces->surfaces_absorbed;
    stats->leaving += surfaces->leaving;
}

ty_result ty_surface_light_solve(const ty_diffusion_def* def, const float* unscattered,
                                 const ty_diffuse_surfaces* surfaces, const ty_incident_flux* incident, int32_t channel,
                                 ty_diffuse_light* light, ty_diffusion_stats* stats) {
    ty_context* context = light->context;
    const size_t count = (size_t)surfaces->faces->count;
    surface_job job = {.def = def, .surfaces = surfaces, .incident = incident, .channel = channel, .light = light};
    bool complete = true;
    float** const sides[] = {&job.side_flux, &job.irradiance, &job.unscattered_irradiance};
    for (int i = 0; i < 3; ++i) {
        *sides[i] = ty_alloc_array(context, count, sizeof(float), true);
        complete = complete && *sides[i] != NULL;
    }
    for (int t = 0; t < TY_FIELD_TERMS; ++t) {
        job.terms[t] = ty_alloc_array(context, term_size(light, t), sizeof(float), true);
        complete = complete && job.terms[t] != NULL;
    }
    job.source = ty_alloc_array(context, light->cells, sizeof(float), false);
    ty_result result = complete && job.source != NULL ? TY_OK : TY_ERROR_MEMORY;
    ty_diffusion_stats before;
    if (result == TY_OK) {
        memcpy(job.source, def->source, sizeof(float) * light->cells);
        result = carry_surface_light(&job, unscattered, &before);
    }
    if (result == TY_OK) result = solve_collided(&job, stats);
    if (result == TY_OK) add_stats(stats, &before);
    for (int i = 0; i < 3; ++i) ty_free_array(context, *sides[i], count, sizeof(float));
    for (int t = 0; t < TY_FIELD_TERMS; ++t) ty_free_array(context, job.terms[t], term_size(light, t), sizeof(float));
    ty_free_array(context, job.source, light->cells, sizeof(float));
    return result;
}
