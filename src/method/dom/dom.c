/* Entry points: a solve, its images, and both in one call. */
#include "base/context.h"
#include "method/dom/solve/solve.h"
#include "method/dom/sources/sources.h"
#include "method/dom/view/view.h"
#include "scene/scene.h"

/* Progress of a solve after each of its parts, and the fraction of a render that the solve takes. */
static const double medium_until = 0.1, direct_until = 0.4, solve_share = 0.7;

/* ---- solving ---- */

static void end_job(ty_dom_job* job) {
    const size_t terms = (size_t)job->light->bands * (size_t)job->light->bands;
    for (int c = 0; c < 3; ++c) ty_free_array(job->context, job->source[c], job->light->cells, terms * sizeof(float));
    ty_discrete_light_set_destroy(job->context, &job->sources);
    ty_free_array(job->context, job->set, 1, sizeof *job->set);
    ty_free_array(job->context, job->last_set, 1, sizeof *job->last_set);
    ty_dom_free_boundary(job);
    ty_grid_medium_destroy(job->coarse);
    ty_grid_medium_destroy(job->fine);
}

static ty_result run_part(ty_dom_job* job, const char* stage, double until, ty_result (*run)(ty_dom_job* job),
                          double* seconds) {
    const double begun = ty_wall_seconds();
    ty_result result = ty_part_next(&job->progress, stage, until);
    if (result == TY_OK) result = run(job);
    *seconds = ty_wall_seconds() - begun;
    return result;
}

static ty_result run_parts(ty_dom_job* job, double fraction) {
    ty_dom_stats* stats = &job->stats;
    ty_result result = run_part(job, "media", fraction * medium_until, ty_dom_sample_media, &stats->medium_seconds);
    if (result == TY_OK) result = ty_dom_find_boundary(job);
    if (result == TY_OK) result = ty_dom_collect_lights(job);
    if (result == TY_OK)
        result = run_part(job, "direct light", fraction * direct_until, ty_dom_find_uncollided, &stats->direct_seconds);
    stats->direct_seconds -= stats->source_seconds;
    if (result == TY_OK)
        result = run_part(job, "walls", fraction * direct_until, ty_dom_light_boundary, &stats->wall_seconds);
    if (result == TY_OK) result = run_part(job, "ordinates", fraction, ty_dom_solve_channels, &stats->solve_seconds);
    return result;
}

/* share: fraction of the caller's progress that the solve takes. */
static ty_result solve(const ty_scene* scene, const ty_dom_def* def, double fraction, ty_dom** out,
                       ty_dom_stats* stats) {
    ty_context* context = ty_scene_context(scene);
    ty_result result = ty_scene_check_media(scene, "dom");
    if (result != TY_OK) return result;
    ty_dom_job job = {.context = context, .scene = scene, .def = def};
    job.progress = ty_part_begin(def->progress, def->progress_user, 0, 0);
    job.light = ty_alloc_array(context, 1, sizeof *job.light, true);
    if (job.light == NULL) return TY_ERROR_MEMORY;
    job.light->context = context;
    result = run_parts(&job, fraction);
    job.stats.seconds = ty_wall_seconds() - job.progress.begun;
    end_job(&job);
    if (result != TY_OK) {
        ty_dom_destroy(job.light);
        return result;
    }
    *stats = job.stats;
    *out = job.light;
    return TY_OK;
}

ty_result ty_dom_solve(const ty_scene* scene, const ty_dom_def* def, ty_dom** out, ty_dom_stats* stats) {
    *out = NULL;
    ty_dom_def known;
    ty_dom_stats own;
    ty_result result = ty_dom_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_dom_stats", &own, sizeof own);
    if (result == TY_OK) result = solve(scene, def, 1, out, &own);
    if (result == TY_OK) ty_give_stats(&own, sizeof own, stats);
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
        ty_free_array(context, light->g[c], light->cells, sizeof(float));
        ty_free_array(context, light->moments[c], light->cells, bytes);
        if (light->face_fluence[c] != NULL)
            ty_free_array(context, light->face_fluence[c], 6 * light->cells, sizeof(float));
        ty_free_array(context, light->wall_moments[c], light->cells, bytes);
    }
    const size_t sides = light->boundary != NULL ? (size_t)light->boundary->count : 0;
    for (int c = 0; c < 3; ++c) {
        ty_free_array(context, light->wall_irradiance[c], sides, sizeof(float));
        ty_free_array(context, light->wall_forward[c], sides, sizeof(float));
    }
    ty_boundary_faces_destroy(light->boundary);
    ty_free_array(context, light->unlit, light->cells, 1);
    ty_free_array(context, light, 1, sizeof *light);
}

/* ---- images ---- */

ty_result ty_dom_view(const ty_dom* light, const ty_scene* scene, const ty_dom_def* def, ty_image** out,
                      ty_dom_stats* stats) {
    *out = NULL;
    ty_dom_def known;
    ty_dom_stats own;
    ty_result result = ty_dom_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_dom_stats", &own, sizeof own);
    if (result != TY_OK) return result;
    result = ty_dom_march(light, scene, def, ty_part_begin(def->progress, def->progress_user, 0, 1), out, &own);
    if (result == TY_OK) ty_give_stats(&own, sizeof own, stats);
    return result;
}

ty_result ty_dom_render(const ty_scene* scene, const ty_dom_def* def, ty_image** out, ty_dom_stats* stats) {
    *out = NULL;
    ty_dom* light = NULL;
    ty_dom_stats own;
    const double begun = ty_wall_seconds();
    ty_dom_def known;
    ty_result result = ty_dom_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_dom_stats", &own, sizeof own);
    if (result == TY_OK) result = solve(scene, def, solve_share, &light, &own);
    if (result != TY_OK) return result;
    ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, solve_share, 1 - solve_share);
    progress.begun = begun;
    result = ty_dom_march(light, scene, def, progress, out, &own);
    ty_dom_destroy(light);
    ty_give_stats(&own, sizeof own, stats);
    return result;
}
