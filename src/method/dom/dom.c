/* Entry points: a solve, its images, and both in one call. */
#include "base/context.h"
#include "base/mapping.h"
#include "method/dom/flux_request.h"
#include "method/dom/solve/solve.h"
#include "method/dom/sources/sources.h"
#include "method/dom/view/view.h"
#include "scene/scene.h"

#include <string.h>

/* Progress of a solve after each stage. */
static const double medium_until = 0.1, direct_until = 0.4, ordinates_until = 0.8;

/* ---- solving ---- */

/* Differentiable light keeps its sources. */
static void keep_sources(ty_dom_job* job) {
    for (int c = 0; c < 3 && job->def->differentiable; ++c) {
        job->light->source[c] = job->source[c];
        job->source[c] = NULL;
    }
}

static void end_job(ty_dom_job* job) {
    const size_t terms = (size_t)job->light->bands * (size_t)job->light->bands;
    for (int c = 0; c < 3; ++c) {
        ty_free_large(job->context, job->source[c], job->light->cells, terms * sizeof(float));
        ty_free_large(job->context, job->centers[c], job->light->cells, 4 * sizeof(float));
    }
    ty_discrete_light_set_destroy(job->context, &job->sources);
    ty_dom_free_boundary(job);
    ty_free_array(job->context, job->set, 1, sizeof *job->set);
    ty_free_array(job->context, job->last_set, 1, sizeof *job->last_set);
    ty_grid_medium_destroy(job->coarse);
    ty_grid_medium_destroy(job->fine);
}

TY_DEFINE_RUN_STAGE(ty_dom_job);

/* Fails if the scene repeats and has what images of it cannot have here. */
static ty_result check_repeated(const ty_dom_job* job) {
    const ty_scene_view* view = ty_scene_get_view(job->scene);
    const int32_t axes = view->periodic.axes;
    const char* why = NULL;
    if (axes == 0) return TY_OK;
    if (axes == 1 || axes == 2 || axes == 4) why = "scenes that repeat along one axis alone";
    if (view->mesh != NULL) why = "surfaces";
    if (job->def->last_directions > 0) why = "last_directions";
    if (job->def->differentiable) why = "gradients";
    return why == NULL ? TY_OK
                       : ty_fail(job->context, TY_ERROR_ARGUMENT,
                                 "periodic: dom does without %s in periodic scenes; the method path has them", why);
}

static ty_result run_stages(ty_dom_job* job, double fraction) {
    ty_dom_stats* stats = &job->stats;
    ty_result result = check_repeated(job);
    if (result == TY_OK)
        result = run_stage(job, "media", fraction * medium_until, ty_dom_sample_media, &stats->medium_seconds);
    if (result == TY_OK) result = ty_dom_find_boundary(job);
    if (result == TY_OK) result = ty_dom_collect_lights(job);
    if (result == TY_OK) result = ty_dom_flux_begin(job);
    if (result == TY_OK)
        result =
            run_stage(job, "direct light", fraction * direct_until, ty_dom_find_uncollided, &stats->direct_seconds);
    stats->direct_seconds -= stats->source_seconds;
    if (result == TY_OK)
        result = run_stage(job, "walls", fraction * direct_until, ty_dom_light_boundary, &stats->wall_seconds);
    if (result == TY_OK)
        result = run_stage(job, "ordinates", fraction * ordinates_until, ty_dom_solve_channels, &stats->solve_seconds);
    double seconds = 0;
    if (result == TY_OK) result = run_stage(job, "interreflection", fraction, ty_dom_interreflect, &seconds);
    stats->solve_seconds += seconds;
    return result == TY_OK ? ty_dom_flux_fill(job) : result;
}

static ty_result solve(ty_volume_call* call) {
    ty_dom_job job = {.context = call->context,
                      .scene = call->scene,
                      .def = call->def,
                      .progress = call->progress,
                      .flux = call->extra,
                      .light = call->light};
    job.light->context = call->context;
    const ty_result result = run_stages(&job, call->fraction);
    memcpy(call->stats, &job.stats, sizeof job.stats);
    keep_sources(&job);
    end_job(&job);
    return result;
}

void ty_dom_destroy(ty_dom* light) {
    if (light == NULL) return;
    ty_context* context = light->context;
    const size_t bytes = (size_t)light->output_bands * (size_t)light->output_bands * sizeof(float);
    for (int i = 0; i < TY_DOM_DEDICATED_MAX; ++i)
        for (int f = 0; f < TY_FLUENCE_COUNT; ++f) {
            ty_light_field_destroy(light->fields[i][f]);
            ty_light_field_destroy(light->coarse_fields[i][f]);
        }
    ty_light_field_destroy(light->aggregate);
    ty_dom_environment_destroy(light);
    ty_dom_clusters_destroy(light);
    for (int c = 0; c < 3; ++c) {
        ty_free_large(context, light->g[c], light->cells, sizeof(float));
        ty_free_array(context, light->extinction[c], light->cells, sizeof(float));
        ty_free_array(context, light->darkening[c], light->cells, sizeof(float));
        ty_free_array(context, light->similarity[c], light->cells, sizeof(float));
        ty_free_large(context, light->moments[c], light->cells, bytes);
        ty_free_large(context, light->source[c], light->cells,
                      (size_t)light->bands * (size_t)light->bands * sizeof(float));
        if (light->face_fluence[c] != NULL)
            ty_free_array(context, light->face_fluence[c], 6 * light->cells, sizeof(float));
        if (light->face_even[c] != NULL) ty_free_array(context, light->face_even[c], 6 * light->cells, sizeof(float));
        ty_free_large(context, light->wall_moments[c], light->cells, bytes);
    }
    const size_t sides = light->boundary != NULL ? (size_t)light->boundary->count : 0;
    for (int c = 0; c < 3; ++c) {
        ty_free_array(context, light->wall_irradiance[c], sides, sizeof(float));
        ty_free_array(context, light->wall_forward[c], sides, sizeof(float));
    }
    ty_boundary_faces_destroy(light->boundary);
    ty_irradiance_cache_destroy(light->cache);
    ty_free_array(context, light->unlit, light->cells, 1);
    ty_free_array(context, light, 1, sizeof *light);
}

/* ---- calls ---- */

/* ty_dom_solve, ty_dom_view and ty_dom_render. */
TY_DEFINE_VOLUME_CALLS(dom);

static void coarsen(void* user, ty_solve_quality quality) {
    ty_dom_def* def = user;
    ty_lower_option(&def->directions, 24);
    ty_lower_option(&def->last_directions, 0);
    ty_lower_option(&def->resolution, ty_coarse_bound(quality, 16));
    ty_lower_option(&def->direct, ty_coarse_bound(quality, 64));
    ty_lower_option(&def->environment_beams, 16);
    ty_lower_option(&def->surface_points, 4);
    def->tolerance = fmax(def->tolerance, 0.02);
}

const ty_volume_method ty_volume_dom = {TY_VOLUME_METHOD(dom),
                                        .solve_fraction = 0.7,
                                        .repeats = true,
                                        .solve = solve,
                                        .view = ty_dom_march,
                                        .coarsen = coarsen,
                                        .start_at = offsetof(ty_dom_def, start),
                                        .interior_at = offsetof(ty_dom_def, interior_resolution)};
