/* Entry points. */
#include "method/fld/job.h"

#include "base/context.h"
#include "image/march.h"
#include "scene/scene.h"
#include "solve/diffusion/diffusion.h"

/* Fractions of a solve's work done after each stage, and fraction of a render spent on the solve: for progress. */
static const double medium_until = 0.15, direct_until = 0.5, diffuse_until = 0.9, solve_fraction = 0.5;

/* ---- solving ---- */

static void end_job(ty_fld_job* job) {
    if (job->coarse != NULL)
        for (int c = 0; c < 3; ++c) ty_free_array(job->context, job->source[c], job->coarse->cells, sizeof(float));
    ty_discrete_light_set_destroy(job->context, &job->sources);
    ty_grid_medium_destroy(job->coarse);
    ty_grid_medium_destroy(job->fine);
}

static ty_result run_stage(ty_fld_job* job, const char* stage, double until, ty_result (*run)(ty_fld_job* job),
                           double* seconds) {
    const double begun = ty_wall_seconds();
    ty_result result = ty_part_next(&job->progress, stage, until);
    if (result == TY_OK) result = run(job);
    *seconds = ty_wall_seconds() - begun;
    return result;
}

static ty_result run_stages(ty_fld_job* job, double fraction) {
    ty_fld_stats* stats = &job->stats;
    ty_result result = run_stage(job, "media", fraction * medium_until, ty_fld_sample_media, &stats->medium_seconds);
    if (result == TY_OK)
        result = run_stage(job, "direct light", fraction * direct_until, ty_fld_direct_light, &stats->direct_seconds);
    if (result == TY_OK)
        result = run_stage(job, "fluence", fraction * diffuse_until, ty_fld_diffuse, &stats->solve_seconds);
    double seconds = 0;
    if (result == TY_OK) result = run_stage(job, "finer fluence", fraction, ty_fld_refine, &seconds);
    stats->solve_seconds += seconds;
    return result;
}

/* fraction: of the caller's progress covered by the solve. */
static ty_result solve(const ty_scene* scene, const ty_fld_def* def, double fraction, ty_fld** out,
                       ty_fld_stats* stats) {
    ty_context* context = ty_scene_context(scene);
    ty_result result = ty_scene_check_media(scene, "fld");
    if (result != TY_OK) return result;
    ty_fld_job job = {.context = context, .scene = scene, .def = def};
    job.progress = ty_part_begin(def->progress, def->progress_user, 0, 0);
    job.light = ty_alloc_array(context, 1, sizeof *job.light, true);
    if (job.light == NULL) return TY_ERROR_MEMORY;
    job.light->context = context;
    job.light->reduced = def->beam == TY_FLD_BEAM_REDUCED;
    result = run_stages(&job, fraction);
    job.stats.seconds = ty_wall_seconds() - job.progress.begun;
    end_job(&job);
    if (result != TY_OK) {
        ty_fld_destroy(job.light);
        return result;
    }
    *stats = job.stats;
    *out = job.light;
    return TY_OK;
}

ty_result ty_fld_solve(const ty_scene* scene, const ty_fld_def* def, ty_fld** out, ty_fld_stats* stats) {
    *out = NULL;
    ty_fld_def known;
    ty_fld_stats own;
    ty_result result = ty_fld_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_fld_stats", &own, sizeof own);
    if (result == TY_OK) result = solve(scene, def, 1, out, &own);
    if (result == TY_OK) ty_give_stats(&own, sizeof own, stats);
    return result;
}

void ty_fld_destroy(ty_fld* light) {
    if (light == NULL) return;
    for (int i = 0; i <= TY_FLD_DEDICATED_FIELDS_MAX; ++i) ty_light_field_destroy(light->beam[i]);
    ty_diffuse_light_destroy(light->diffuse);
    ty_free_array(light->context, light, 1, sizeof *light);
}

/* ---- images ---- */

static ty_result view(const ty_fld* light, const ty_scene* scene, const ty_fld_def* def, ty_part_progress progress,
                      ty_image** out, ty_fld_stats* stats) {
    const ty_source_field field = ty_diffuse_light_field(light->diffuse, ty_scene_get_view(scene)->mesh != NULL);
    const ty_image_options options = ty_fld_image_options(def);
    ty_march_def march = ty_march_def_of(scene, &options);
    march.light_box = light->direct_box;
    march.lights = light->lights;
    march.light_count = light->light_count;
    march.reduced = light->reduced;
    march.field = &field;
    march.bilateral_sigma = 0;
    march.preserve_means = true;
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

ty_result ty_fld_view(const ty_fld* light, const ty_scene* scene, const ty_fld_def* def, ty_image** out,
                      ty_fld_stats* stats) {
    *out = NULL;
    ty_fld_def known;
    ty_fld_stats own;
    ty_result result = ty_fld_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_fld_stats", &own, sizeof own);
    if (result != TY_OK) return result;
    const ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, 0, 1);
    result = view(light, scene, def, progress, out, &own);
    if (result == TY_OK) ty_give_stats(&own, sizeof own, stats);
    return result;
}

ty_result ty_fld_render(const ty_scene* scene, const ty_fld_def* def, ty_image** out, ty_fld_stats* stats) {
    *out = NULL;
    ty_fld* light = NULL;
    ty_fld_stats own;
    const double begun = ty_wall_seconds();
    ty_fld_def known;
    ty_result result = ty_fld_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_fld_stats", &own, sizeof own);
    if (result == TY_OK) result = solve(scene, def, solve_fraction, &light, &own);
    if (result != TY_OK) return result;
    ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, solve_fraction, 1 - solve_fraction);
    progress.begun = begun;
    result = view(light, scene, def, progress, out, &own);
    ty_fld_destroy(light);
    ty_give_stats(&own, sizeof own, stats);
    return result;
}
