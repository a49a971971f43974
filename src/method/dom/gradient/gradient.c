/* The gradient of a loss on the fluence: the adjoint of the fluence's means over the caller's cells, of ordinates, of
 * first-collision sources, and of uncollided light, in this order. */
#include "method/dom/gradient/gradient.h"

#include "base/context.h"
#include "method/dom/solve/solve.h"
#include "method/dom/sources/sources.h"

#include <string.h>

/* Progress after the lights of the solve are found again, and after the adjoint of ordinates. */
static const double LIGHTS_UNTIL = 0.02, ORDINATES_UNTIL = 0.7;

static ty_result allocate(ty_dom_gradient_job* job) {
    for (int c = 0; c < 3; ++c) {
        job->weight[c] = ty_alloc_array(job->dom.context, job->dom.fine->cells, sizeof(float), true);
        job->source_weight[c] = ty_alloc_array(job->dom.context, job->dom.coarse->cells, sizeof(float), true);
        if (job->weight[c] == NULL || job->source_weight[c] == NULL) return TY_ERROR_MEMORY;
    }
    return ty_medium_gradient_make(job->dom.coarse, &job->coarse);
}

static void free_all(ty_dom_gradient_job* job) {
    ty_dom_job* dom = &job->dom;
    if (dom->fine != NULL && dom->coarse != NULL) {
        ty_dom_gradient_free_channels(job);
        for (int c = 0; c < 3; ++c) {
            ty_free_array(dom->context, job->weight[c], dom->fine->cells, sizeof(float));
            ty_free_array(dom->context, job->source_weight[c], dom->coarse->cells, sizeof(float));
        }
    }
    ty_medium_gradient_free(&job->coarse);
    ty_discrete_light_set_destroy(dom->context, &dom->sources);
    ty_free_array(dom->context, dom->set, 1, sizeof *dom->set);
    ty_free_array(dom->context, dom->last_set, 1, sizeof *dom->last_set);
    ty_grid_medium_destroy(dom->coarse);
    ty_dom_destroy(dom->light);
}

static bool is_same_box(const ty_grid_box* a, const ty_grid_box* b) {
    return memcmp(a->lower, b->lower, sizeof a->lower) == 0 && memcmp(a->upper, b->upper, sizeof a->upper) == 0 &&
           memcmp(a->size, b->size, sizeof a->size) == 0;
}

/* Errors if the light cannot be that of this scene and these options. */
static ty_result check(const ty_dom_gradient_job* job) {
    const ty_dom *again = job->dom.light, *light = job->light;
    bool same = is_same_box(&again->fine_box, &light->fine_box) && is_same_box(&again->box, &light->box) &&
                again->bands == light->bands && again->fit.bands == light->fit.bands &&
                again->planes == light->planes && again->shared == light->shared;
    for (int c = 0; c < 3; ++c) same = same && again->color[c] == light->color[c];
    if (same) return TY_OK;
    return ty_fail(job->dom.context, TY_ERROR_ARGUMENT,
                   "gradient: the light is that of another scene or other options");
}

/* The mean cosines of the media, as first-collision sources take them. */
static ty_result find_g(ty_dom_gradient_job* job) {
    ty_dom_scratch scratch = {.scattered = NULL};
    const ty_result result = ty_dom_scratch_create(&job->dom, &scratch);
    memcpy(job->g, scratch.g, sizeof job->g);
    memcpy(job->uniform, scratch.uniform, sizeof job->uniform);
    ty_dom_scratch_destroy(&job->dom, &scratch);
    ty_dom_gradient_find_fit(job);
    return result;
}

/* The lights of the solve. */
static ty_result repeat_solve(ty_dom_gradient_job* job) {
    ty_result result = ty_part_next(&job->dom.progress, "adjoint", LIGHTS_UNTIL);
    if (result == TY_OK) result = ty_dom_collect_lights(&job->dom);
    if (result == TY_OK) result = check(job);
    return result == TY_OK ? find_g(job) : result;
}

static ty_result differentiate(ty_dom_gradient_job* job, const ty_coverage_box* cells, const double* weights) {
    const ty_grid_medium *fine = job->dom.fine, *coarse = job->dom.coarse;
    const double begun = ty_wall_seconds();
    ty_result result = repeat_solve(job);
    if (result == TY_OK) result = allocate(job);
    if (result != TY_OK) return result;
    ty_gradient_spread_weights(cells, weights, &fine->box, job->weight);
    ty_gradient_spread_weights(cells, weights, &coarse->box, job->source_weight);
    const double prepared = ty_wall_seconds();
    result = ty_part_next(&job->dom.progress, "adjoint", ORDINATES_UNTIL);
    if (result == TY_OK) result = ty_dom_gradient_solve(job);
    const double solved = ty_wall_seconds();
    if (result == TY_OK) result = ty_part_next(&job->dom.progress, "adjoint", 1);
    if (result != TY_OK) return result;
    ty_medium_gradient_refine(&job->coarse, coarse->box.size, fine->box.size, &job->gradient->media);
    result = ty_dom_gradient_return_sources(job);
    job->stats->direct_seconds = ty_wall_seconds() - solved + prepared - begun;
    job->stats->solve_seconds = solved - prepared;
    job->stats->seconds = ty_wall_seconds() - begun;
    return result;
}

static ty_result find_gradient(ty_dom_gradient_job* job, const ty_coverage_box* cells, const double* weights,
                               ty_gradient** out) {
    ty_result result = ty_dom_sample_media(&job->dom);
    if (result == TY_OK)
        result = ty_gradient_create(job->dom.scene, job->dom.fine, &job->gradient);
    else
        ty_grid_medium_destroy(job->dom.fine);
    if (result != TY_OK) job->dom.fine = NULL;
    if (result == TY_OK) result = differentiate(job, cells, weights);
    free_all(job);
    if (result == TY_OK)
        *out = job->gradient;
    else
        ty_gradient_destroy(job->gradient);
    return result;
}

ty_result ty_dom_gradient(const ty_dom* light, const ty_scene* scene, const ty_dom_def* def, const double lower[3],
                          const double upper[3], const int32_t size[3], const double* weights, ty_gradient** out,
                          ty_gradient_stats* stats) {
    _Alignas(16) char own[TY_VOLUME_DEF_MAX];
    ty_context* context = ty_scene_context(scene);
    ty_gradient_stats totals;
    const ty_coverage_box cells = {lower, upper, size};
    *out = NULL;
    ty_result result = ty_gradient_begin(scene, &ty_volume_dom, def, own, false, &cells, stats, &totals);
    if (result != TY_OK) return result;
    ty_dom_gradient_job job = {
        .dom = {.context = context, .scene = scene, .def = (const ty_dom_def*)own}, .light = light, .stats = &totals};
    if (!job.dom.def->differentiable || light->source[0] == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "gradient: dom.differentiable: light has a gradient where it was solved with true");
    if (job.dom.def->last_directions > 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "gradient: dom.last_directions: dom is differentiated without them");
    job.dom.light = ty_alloc_array(context, 1, sizeof *job.dom.light, true);
    if (job.dom.light == NULL) return TY_ERROR_MEMORY;
    job.dom.light->context = context;
    job.dom.progress = ty_part_begin(job.dom.def->progress, job.dom.def->progress_user, 0, 0);
    result = find_gradient(&job, &cells, weights, out);
    if (result == TY_OK) ty_give_stats(&totals, sizeof totals, stats);
    return result;
}
