/* The gradient of a loss on the fluence: the adjoint of the fluence's means over the caller's cells, of diffusion, of
 * its source, and of uncollided light, in this order. */
#include "method/gradient/gradient.h"

#include "base/context.h"
#include "base/kernel.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/first_collision_source.h"
#include "method/fld/job.h"
#include "solve/diffusion/light/diffuse_adjoint.h"

#include <math.h>
#include <string.h>

/* Bound of the adjoint equation's residual; the light's own, above which it is no solution; largest ratio of cells
 * without refinement. */
static const double TOLERANCE = 3e-5, MAX_IMBALANCE = 0.1, MAX_RATIO = 3;

/* Progress after the adjoint of diffusion. */
static const double DIFFUSION_UNTIL = 0.7;

typedef struct gradient_job {
    ty_fld_job fld; /* media, lights and sources as in the solve */
    ty_fld copy;    /* of the light */
    ty_gradient* gradient;
    float *weight[3], *source_weight[3]; /* dL/dfluence of fine and coarse cells, per channel */
    float *by_source[3], *by_fine;       /* dL/dq of coarse cells, and of fine ones for one channel */
    int32_t spread;                      /* that channel */
    float *extinction[3], *by_extinction[3];
    ty_medium_gradient coarse;
} gradient_job;

static bool allocate_array(const gradient_job* job, size_t cells, float** out) {
    *out = ty_alloc_array(job->fld.context, cells, sizeof(float), true);
    return *out != NULL;
}

static ty_result allocate(gradient_job* job) {
    const ty_grid_medium *fine = job->fld.fine, *coarse = job->fld.coarse;
    bool whole = allocate_array(job, fine->cells, &job->by_fine);
    for (int c = 0; c < 3; ++c)
        whole = whole && allocate_array(job, fine->cells, &job->weight[c]) &&
                allocate_array(job, coarse->cells, &job->source_weight[c]) &&
                allocate_array(job, coarse->cells, &job->by_source[c]);
    for (int32_t p = 0; p < fine->planes; ++p)
        whole = whole && allocate_array(job, fine->cells, &job->extinction[p]) &&
                allocate_array(job, fine->cells, &job->by_extinction[p]);
    return whole ? ty_medium_gradient_make(coarse, &job->coarse) : TY_ERROR_MEMORY;
}

/* fine: cells of direct light. */
static void free_all(gradient_job* job, size_t fine) {
    const size_t coarse = job->fld.coarse != NULL ? job->fld.coarse->cells : 0;
    ty_free_array(job->fld.context, job->by_fine, fine, sizeof(float));
    for (int c = 0; c < 3; ++c) {
        float* const on_fine[] = {job->weight[c], job->extinction[c], job->by_extinction[c]};
        for (int i = 0; i < 3; ++i) ty_free_array(job->fld.context, on_fine[i], fine, sizeof(float));
        float* const on_coarse[] = {job->source_weight[c], job->by_source[c], job->fld.source[c]};
        for (int i = 0; i < 3; ++i) ty_free_array(job->fld.context, on_coarse[i], coarse, sizeof(float));
    }
    ty_medium_gradient_free(&job->coarse);
    ty_discrete_light_set_destroy(job->fld.context, &job->fld.sources);
    ty_grid_medium_destroy(job->fld.coarse);
}

static bool is_same_box(const ty_grid_box* a, const ty_grid_box* b) {
    return memcmp(a->lower, b->lower, sizeof a->lower) == 0 && memcmp(a->upper, b->upper, sizeof a->upper) == 0 &&
           memcmp(a->size, b->size, sizeof a->size) == 0;
}

static ty_result check(const gradient_job* job, const ty_fld* light) {
    ty_context* context = job->fld.context;
    if (job->fld.def->ratio > MAX_RATIO)
        return ty_fail(context, TY_ERROR_ARGUMENT, "gradient: fld.ratio: above %g fld is not differentiated",
                       MAX_RATIO);
    if (!is_same_box(&job->copy.direct_box, &light->direct_box) ||
        !is_same_box(&job->fld.coarse->box, &light->diffuse->box))
        return ty_fail(context, TY_ERROR_ARGUMENT, "gradient: the light is that of another scene or other options");
    return TY_OK;
}

/* The media, lights and sources of the solve. */
static ty_result repeat_solve(gradient_job* job) {
    const ty_discretize_def lights = {.environment = job->fld.def->environment_beams,
                                      .surface = job->fld.def->surface_points,
                                      .seed = job->fld.def->seed};
    ty_result result = ty_discretize_lights(job->fld.scene, &lights, &job->fld.sources);
    if (result == TY_OK) result = ty_fld_find_sources(&job->fld, job->fld.coarse, job->fld.source);
    if (result == TY_OK) ty_scaled_extinction(job->fld.fine, job->copy.reduced ? 1 : 0, job->extinction);
    return result;
}

/* The adjoint of diffusion, and of the means that its media and sources are. */
static ty_result return_diffusion(gradient_job* job, ty_gradient_stats* stats) {
    const ty_grid_medium *fine = job->fld.fine, *coarse = job->fld.coarse;
    const ty_diffusion_def solver = ty_fld_diffusion_def(&job->fld);
    double by_streaming;
    const ty_diffuse_loss loss = {.light = job->copy.diffuse,
                                  .solver = &solver,
                                  .reduced = job->copy.reduced,
                                  .medium = coarse,
                                  .source = job->fld.source,
                                  .weight = job->source_weight,
                                  .tolerance = TOLERANCE,
                                  .by_streaming = &by_streaming,
                                  .progress = &job->fld.progress};
    ty_diffusion_adjoint_stats solved;
    const ty_result result = ty_diffuse_adjoint(&loss, &job->coarse, job->by_source, &solved);
    if (result != TY_OK) return result;
    stats->converged = solved.converged;
    stats->iterations = solved.iterations;
    stats->residual = solved.residual;
    stats->imbalance = solved.imbalance;
    if (!(solved.imbalance <= MAX_IMBALANCE))
        return ty_fail(job->fld.context, TY_ERROR_ARGUMENT,
                       "gradient: the light is no solution of this scene: its residual is %g of its source",
                       solved.imbalance);
    ty_fld_return_flux_fraction(&job->fld, by_streaming, job->gradient->lights);
    ty_medium_gradient_refine(&job->coarse, coarse->box.size, fine->box.size, &job->gradient->media);
    return TY_OK;
}

/* The derivatives by the source of fine cells, as `by_fine` times the number that is returned. */
static float spread_source(gradient_job* job, int32_t channel) {
    const ty_grid_medium *fine = job->fld.fine, *coarse = job->fld.coarse;
    float multiple;
    if (channel > 0 && ty_is_multiple(job->by_source[channel], job->by_source[job->spread], coarse->cells, &multiple))
        return multiple;
    memset(job->by_fine, 0, sizeof(float) * fine->cells);
    ty_grid_spread(job->fld.context, job->by_source[channel], coarse->box.size, fine->box.size, job->by_fine);
    job->spread = channel;
    return 1;
}

/* The adjoint of the first-collision source q = (1 - g) sigma_s phi of fine cells: adds the derivatives by the media,
 * and to the weights of uncollided light those by its fluence phi. Negative g counts as 0. */
static void return_source(gradient_job* job, int32_t channel) {
    const ty_grid_medium* fine = job->fld.fine;
    const int32_t p = fine->planes == 3 ? channel : 0;
    const float multiple = spread_source(job, channel);
    ty_medium_gradient* media = &job->gradient->media;
    for (int32_t l = 0; l < job->copy.light_count; ++l) {
        float factor;
        const float* fluence = ty_light_fluence_plane(&job->copy.lights[l], channel, &factor);
        factor *= multiple;
        for (size_t i = 0; i < fine->cells; ++i) {
            const float by_scattering = job->by_fine[i] * factor * fluence[i];
            media->scattering[p][i] += by_scattering;
            if (job->copy.reduced && fine->g[p][i] > 0) media->scattering_g[p][i] -= by_scattering;
        }
    }
    for (size_t i = 0; i < fine->cells; ++i)
        job->weight[channel][i] +=
            multiple * job->by_fine[i] *
            ty_reduced_scattering(fine->scattering[p][i], job->copy.reduced ? fine->g[p][i] : 0.0f);
}

/* The adjoint of sigma_t - g sigma_s, by which uncollided light is attenuated. */
static void return_extinction(gradient_job* job) {
    const ty_grid_medium* fine = job->fld.fine;
    ty_medium_gradient* media = &job->gradient->media;
    for (int32_t p = 0; p < fine->planes; ++p)
        for (size_t i = 0; i < fine->cells; ++i) {
            media->extinction[p][i] += job->by_extinction[p][i];
            if (job->copy.reduced && fine->g[p][i] > 0) media->scattering_g[p][i] -= job->by_extinction[p][i];
        }
}

static ty_result differentiate(gradient_job* job, const ty_coverage_box* cells, const double* weights,
                               ty_gradient_stats* stats) {
    const double begun = ty_wall_seconds();
    ty_result result = repeat_solve(job);
    if (result != TY_OK) return result;
    ty_gradient_spread_weights(cells, weights, &job->fld.fine->box, job->weight);
    ty_gradient_spread_weights(cells, weights, &job->fld.coarse->box, job->source_weight);
    const double prepared = ty_wall_seconds();
    result = ty_part_next(&job->fld.progress, "adjoint", DIFFUSION_UNTIL);
    if (result == TY_OK) result = return_diffusion(job, stats);
    const double solved = ty_wall_seconds();
    if (result == TY_OK) result = ty_part_next(&job->fld.progress, "adjoint", 1);
    if (result != TY_OK) return result;
    for (int32_t c = 0; c < 3; ++c) return_source(job, c);
    result = ty_gradient_add_uncollided(job->gradient, job->fld.scene, &job->fld.sources, job->extinction, job->weight,
                                        job->by_extinction, &job->fld.progress);
    return_extinction(job);
    stats->direct_seconds = ty_wall_seconds() - solved;
    stats->solve_seconds = solved - prepared;
    stats->seconds = ty_wall_seconds() - begun;
    return result;
}

static ty_result find_gradient(gradient_job* job, const ty_fld* light, const ty_coverage_box* cells,
                               const double* weights, ty_gradient** out, ty_gradient_stats* stats) {
    ty_result result = ty_fld_sample_media(&job->fld);
    const size_t fine = job->fld.fine != NULL ? job->fld.fine->cells : 0;
    if (result == TY_OK)
        result = ty_gradient_create(job->fld.scene, job->fld.fine, &job->gradient);
    else
        ty_grid_medium_destroy(job->fld.fine);
    if (result == TY_OK) result = check(job, light);
    if (result == TY_OK) result = allocate(job);
    if (result == TY_OK) result = differentiate(job, cells, weights, stats);
    free_all(job, fine);
    if (result == TY_OK)
        *out = job->gradient;
    else
        ty_gradient_destroy(job->gradient);
    return result;
}

ty_result ty_fld_gradient(const ty_fld* light, const ty_scene* scene, const ty_fld_def* def, const double lower[3],
                          const double upper[3], const int32_t size[3], const double* weights, ty_gradient** out,
                          ty_gradient_stats* stats) {
    _Alignas(16) char own[TY_VOLUME_DEF_MAX];
    ty_context* context = ty_scene_context(scene);
    ty_gradient_stats totals;
    const ty_coverage_box cells = {lower, upper, size};
    *out = NULL;
    ty_result result = ty_gradient_begin(scene, &ty_volume_fld, def, own, true, &cells, stats, &totals);
    if (result != TY_OK) return result;
    gradient_job job = {.fld = {.context = context, .scene = scene, .def = (const ty_fld_def*)own}, .copy = *light};
    job.fld.light = &job.copy;
    job.fld.progress = ty_part_begin(job.fld.def->progress, job.fld.def->progress_user, 0, 0);
    result = find_gradient(&job, light, &cells, weights, out, &totals);
    if (result == TY_OK) ty_give_stats(&totals, sizeof totals, stats);
    return result;
}
