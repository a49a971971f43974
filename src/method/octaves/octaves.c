/* Multiple scattering octaves: entry points. */
#include "method/octaves/job.h"

#include "base/context.h"
#include "scene/scene.h"

#include <string.h>

/* Progress fractions: of a solve after sampling the media, of a render after the solve. */
static const double medium_until = 0.2, solve_fraction = 0.4;

/* ---- solving ---- */

static ty_result sample_media(ty_octaves_job* job) {
    const int32_t longest = ty_grid_box_longest(job->scene, job->def->resolution);
    ty_result result = ty_grid_box_fit(job->scene, longest, &job->light->box);
    if (result == TY_OK) result = ty_grid_medium_create(job->scene, &job->light->box, &job->medium);
    if (result != TY_OK) return result;
    memcpy(job->stats.size, job->light->box.size, sizeof job->stats.size);
    job->stats.planes = job->medium->planes;
    return TY_OK;
}

static ty_result run_stage(ty_octaves_job* job, const char* stage, double until, ty_result (*run)(ty_octaves_job* job),
                           double* seconds) {
    const double begun = ty_wall_seconds();
    ty_result result = ty_part_next(&job->progress, stage, until);
    if (result == TY_OK) result = run(job);
    *seconds = ty_wall_seconds() - begun;
    return result;
}

/* fraction: the solve's span of the caller's progress. */
static ty_result solve(const ty_scene* scene, const ty_octaves_def* def, double fraction, ty_octaves** out,
                       ty_octaves_stats* stats) {
    ty_context* context = ty_scene_context(scene);
    ty_result result = ty_scene_check_media(scene, "octaves");
    if (result != TY_OK) return result;
    ty_octaves_job job = {.context = context, .scene = scene, .def = def};
    job.progress = ty_part_begin(def->progress, def->progress_user, 0, 0);
    job.light = ty_alloc_array(context, 1, sizeof *job.light, true);
    if (job.light == NULL) return TY_ERROR_MEMORY;
    job.light->context = context;
    job.light->octaves = ty_octaves_of(def);
    result = run_stage(&job, "media", fraction * medium_until, sample_media, &job.stats.medium_seconds);
    if (result == TY_OK)
        result = run_stage(&job, "direct light", fraction, ty_octaves_light, &job.stats.direct_seconds);
    job.stats.seconds = ty_wall_seconds() - job.progress.begun;
    ty_grid_medium_destroy(job.medium);
    if (result != TY_OK) {
        ty_octaves_destroy(job.light);
        return result;
    }
    *stats = job.stats;
    *out = job.light;
    return TY_OK;
}

ty_result ty_octaves_solve(const ty_scene* scene, const ty_octaves_def* def, ty_octaves** out,
                           ty_octaves_stats* stats) {
    *out = NULL;
    ty_octaves_def known;
    ty_octaves_stats own;
    ty_result result = ty_octaves_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_octaves_stats", &own, sizeof own);
    if (result == TY_OK) result = solve(scene, def, 1, out, &own);
    if (result == TY_OK) ty_give_stats(&own, sizeof own, stats);
    return result;
}

void ty_octaves_destroy(ty_octaves* light) {
    if (light == NULL) return;
    for (int32_t i = 0; i < TY_OCTAVES_MAX; ++i)
        for (int32_t l = 0; l < TY_OCTAVES_LIGHTS_MAX; ++l) ty_light_field_destroy(light->fields[i][l]);
    ty_free_array(light->context, light, 1, sizeof *light);
}

/* ---- images ---- */

static ty_result view(const ty_octaves* light, const ty_scene* scene, const ty_octaves_def* def,
                      ty_part_progress progress, ty_image** out, ty_octaves_stats* stats) {
    const ty_image_options options = ty_octaves_image_options(def);
    ty_march_octaves octaves = light->octaves;
    octaves.lights = light->lights + light->light_count;
    ty_march_def march = ty_march_def_of(scene, &options);
    march.light_box = light->box;
    march.lights = light->lights;
    march.light_count = light->light_count;
    march.octaves = &octaves;
    march.unscattered = def->unscattered;
    march.progress = ty_part_report;
    march.progress_user = &progress;
    ty_march_stats marched = {0};
    const ty_result result = ty_march(scene, &march, out, &marched);
    if (result == TY_OK) {
        stats->march_seconds = marched.seconds;
        stats->seconds += marched.seconds;
        stats->isa = marched.isa;
    }
    return result;
}

ty_result ty_octaves_view(const ty_octaves* light, const ty_scene* scene, const ty_octaves_def* def, ty_image** out,
                          ty_octaves_stats* stats) {
    *out = NULL;
    ty_octaves_def known;
    ty_octaves_stats own;
    ty_result result = ty_octaves_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_octaves_stats", &own, sizeof own);
    if (result != TY_OK) return result;
    const ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, 0, 1);
    result = view(light, scene, def, progress, out, &own);
    if (result == TY_OK) ty_give_stats(&own, sizeof own, stats);
    return result;
}

ty_result ty_octaves_render(const ty_scene* scene, const ty_octaves_def* def, ty_image** out, ty_octaves_stats* stats) {
    *out = NULL;
    ty_octaves* light = NULL;
    ty_octaves_stats own;
    const double begun = ty_wall_seconds();
    ty_octaves_def known;
    ty_result result = ty_octaves_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_octaves_stats", &own, sizeof own);
    if (result == TY_OK) result = solve(scene, def, solve_fraction, &light, &own);
    if (result != TY_OK) return result;
    ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, solve_fraction, 1 - solve_fraction);
    progress.begun = begun;
    result = view(light, scene, def, progress, out, &own);
    ty_octaves_destroy(light);
    ty_give_stats(&own, sizeof own, stats);
    return result;
}
