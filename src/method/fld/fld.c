/* Entry points. */
#include "method/fld/job.h"

#include "base/context.h"
#include "image/march.h"
#include "scene/scene.h"
#include "solve/diffusion.h"

#include <string.h>

/* Fractions of a solve's work that are done after each part, and the share of a solve in a render: for progress. */
static const double medium_until = 0.15, direct_until = 0.5, solve_share = 0.5;

static const double report_interval = 0.1; /* s */

/* ---- progress ---- */

ty_result ty_fld_next_part(ty_fld_job* job, const char* stage, double until) {
    job->progress.from += job->progress.share;
    job->progress.share = until - job->progress.from;
    job->progress.reported = 0;
    return ty_fld_show_progress(job, stage);
}

ty_result ty_fld_show_progress(ty_fld_job* job, const char* stage) {
    if (ty_wall_seconds() - job->progress.reported < report_interval) return TY_OK;
    const ty_progress begun = {.stage = stage};
    return ty_fld_report(&job->progress, &begun) ? TY_OK : TY_CANCELLED;
}

bool ty_fld_report(void* user, const ty_progress* part) {
    ty_fld_progress* progress = user;
    if (progress->function == NULL) return true;
    progress->reported = ty_wall_seconds();
    ty_progress whole = {.stage = part->stage, .seconds = progress->reported - progress->begun};
    whole.fraction = progress->from + progress->share * part->fraction;
    whole.remaining = whole.fraction > 0.02 ? whole.seconds * (1 - whole.fraction) / whole.fraction : -1;
    return progress->function(progress->user, &whole);
}

/* ---- solving ---- */

static void end_job(ty_fld_job* job) {
    if (job->coarse != NULL)
        for (int c = 0; c < 3; ++c) ty_free_array(job->context, job->source[c], job->coarse->cells, sizeof(float));
    ty_sources_destroy(job->context, job->sources, job->source_count);
    ty_grid_medium_destroy(job->coarse);
    ty_grid_medium_destroy(job->fine);
}

static ty_result run_part(ty_fld_job* job, const char* stage, double until, ty_result (*run)(ty_fld_job* job),
                          double* seconds) {
    const double begun = ty_wall_seconds();
    ty_result result = ty_fld_next_part(job, stage, until);
    if (result == TY_OK) result = run(job);
    *seconds = ty_wall_seconds() - begun;
    return result;
}

static ty_result run_parts(ty_fld_job* job, double share) {
    ty_fld_stats* stats = &job->stats;
    ty_result result = run_part(job, "media", share * medium_until, ty_fld_sample_media, &stats->medium_seconds);
    if (result == TY_OK)
        result = run_part(job, "direct light", share * direct_until, ty_fld_light_directly, &stats->direct_seconds);
    if (result == TY_OK) result = run_part(job, "fluence", share, ty_fld_diffuse, &stats->solve_seconds);
    return result;
}

/* share: of the caller's progress that the solve is. */
static ty_result solve(const ty_scene* scene, const ty_fld_def* def, double share, ty_fld** out, ty_fld_stats* stats) {
    ty_context* context = ty_scene_context(scene);
    ty_result result = ty_fld_check(context, def);
    if (result != TY_OK) return result;
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (view->medium_count == 0) return ty_fail(context, TY_ERROR_ARGUMENT, "fld: the scene has no media");
    ty_fld_job job = {.context = context, .scene = scene, .def = def};
    job.progress = (ty_fld_progress){.function = def->progress, .user = def->progress_user, .begun = ty_wall_seconds()};
    job.light = ty_alloc_array(context, 1, sizeof *job.light, true);
    if (job.light == NULL) return TY_ERROR_MEMORY;
    job.light->context = context;
    job.light->reduced = def->beam == TY_FLD_BEAM_REDUCED;
    result = run_parts(&job, share);
    job.stats.seconds = ty_wall_seconds() - job.progress.begun;
    end_job(&job);
    if (result != TY_OK) {
        ty_fld_destroy(job.light);
        return result;
    }
    if (stats != NULL) *stats = job.stats;
    *out = job.light;
    return TY_OK;
}

ty_result ty_fld_solve(const ty_scene* scene, const ty_fld_def* def, ty_fld** out, ty_fld_stats* stats) {
    *out = NULL;
    return solve(scene, def, 1, out, stats);
}

size_t ty_fld_term_size(const ty_fld* light, int term) {
    if (term == 0 || light->cells == 0) return light->cells;
    return light->cells + light->cells / (size_t)light->box.size[term - 1];
}

void ty_fld_destroy(ty_fld* light) {
    if (light == NULL) return;
    for (int i = 0; i <= TY_FLD_OWN_MAX; ++i) ty_light_field_destroy(light->beam[i]);
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            ty_free_array(light->context, light->terms[c][t], ty_fld_term_size(light, t), sizeof(float));
    ty_free_array(light->context, light, 1, sizeof *light);
}

/* ---- images ---- */

static ty_result view(const ty_fld* light, const ty_scene* scene, const ty_fld_def* def, ty_fld_progress progress,
                      ty_image** out, ty_fld_stats* stats) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const bool directed = !light->even || ty_scene_get_view(scene)->mesh != NULL;
    ty_source_field field = {.box = light->box, .term_count = directed ? TY_FIELD_TERMS : 1, .shared = light->shared};
    for (int c = 0; c < 3; ++c) {
        field.color[c] = light->color[c];
        for (int t = 0; t < TY_FIELD_TERMS; ++t) field.terms[c][t] = light->terms[c][t];
    }
    ty_march_def march = ty_default_march_def();
    march.width = def->width > 0 ? def->width : camera.resolution[0];
    march.height = def->width > 0 ? def->height : camera.resolution[1];
    march.spp = def->spp;
    march.seed = def->seed;
    march.step = def->step;
    march.aovs = def->aovs;
    march.light_box = light->direct_box;
    march.lights = light->lights;
    march.light_count = light->light_count;
    march.reduced = light->reduced;
    march.field = &field;
    march.guided = 0;
    march.keeps_means = true;
    march.unscattered = def->unscattered;
    march.progress = ty_fld_report;
    march.progress_user = &progress;
    ty_march_stats marched = {0};
    const ty_result result = ty_march(scene, &march, out, &marched);
    if (result == TY_OK && stats != NULL) {
        stats->march_seconds = marched.seconds;
        stats->seconds += marched.seconds;
        stats->isa = marched.isa;
    }
    return result;
}

ty_result ty_fld_view(const ty_fld* light, const ty_scene* scene, const ty_fld_def* def, ty_image** out,
                      ty_fld_stats* stats) {
    *out = NULL;
    const ty_result result = ty_fld_check(ty_scene_context(scene), def);
    if (result != TY_OK) return result;
    const ty_fld_progress progress = {
        .function = def->progress, .user = def->progress_user, .begun = ty_wall_seconds(), .share = 1};
    return view(light, scene, def, progress, out, stats);
}

ty_result ty_fld_render(const ty_scene* scene, const ty_fld_def* def, ty_image** out, ty_fld_stats* stats) {
    *out = NULL;
    ty_fld* light = NULL;
    ty_fld_stats own = {0};
    const double begun = ty_wall_seconds();
    ty_result result = solve(scene, def, solve_share, &light, &own);
    if (result != TY_OK) return result;
    const ty_fld_progress progress = {.function = def->progress,
                                      .user = def->progress_user,
                                      .begun = begun,
                                      .from = solve_share,
                                      .share = 1 - solve_share};
    result = view(light, scene, def, progress, out, &own);
    ty_fld_destroy(light);
    if (stats != NULL) *stats = own;
    return result;
}
