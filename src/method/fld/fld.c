/* Entry points. */
#include "method/fld/job.h"

#include "base/context.h"
#include "method/diffuse/view.h"
#include "method/volume_method.h"
#include "scene/scene.h"
#include "solve/diffusion/diffusion.h"

#include <string.h>

/* Fractions of a solve's work done after each stage: for progress. */
static const double medium_until = 0.15, direct_until = 0.5, diffuse_until = 0.8, finer_until = 0.85;

/* ---- solving ---- */

static void end_job(ty_fld_job* job) {
    if (job->coarse != NULL)
        for (int c = 0; c < 3; ++c) ty_free_array(job->context, job->source[c], job->coarse->cells, sizeof(float));
    ty_discrete_light_set_destroy(job->context, &job->sources);
    if (job->coarse != NULL) ty_incident_flux_free(job->context, job->coarse->box.size, &job->incident);
    ty_diffuse_surfaces_destroy(&job->surfaces);
    ty_grid_medium_destroy(job->coarse);
    ty_grid_medium_destroy(job->fine);
}

TY_DEFINE_RUN_STAGE(ty_fld_job);

static ty_result run_stages(ty_fld_job* job, double fraction) {
    ty_fld_stats* stats = &job->stats;
    ty_result result = run_stage(job, "media", fraction * medium_until, ty_fld_sample_media, &stats->medium_seconds);
    if (result == TY_OK)
        result = run_stage(job, "direct light", fraction * direct_until, ty_fld_direct_light, &stats->direct_seconds);
    if (result == TY_OK)
        result = run_stage(job, "fluence", fraction * diffuse_until, ty_fld_diffuse, &stats->solve_seconds);
    double seconds = 0;
    if (result == TY_OK) result = run_stage(job, "finer fluence", fraction * finer_until, ty_fld_refine, &seconds);
    stats->solve_seconds += seconds;
    if (result == TY_OK) result = run_stage(job, "interreflection", fraction, ty_fld_interreflect, &seconds);
    stats->solve_seconds += seconds;
    return result;
}

static ty_result solve(ty_volume_call* call) {
    ty_fld_job job = {.context = call->context,
                      .scene = call->scene,
                      .def = call->def,
                      .progress = call->progress,
                      .light = call->light};
    job.light->context = call->context;
    job.light->reduced = job.def->beam == TY_FLD_BEAM_REDUCED;
    const ty_result result = run_stages(&job, call->fraction);
    memcpy(call->stats, &job.stats, sizeof job.stats);
    end_job(&job);
    return result;
}

void ty_fld_destroy(ty_fld* light) {
    if (light == NULL) return;
    for (int i = 0; i <= TY_FLD_DEDICATED_FIELDS_MAX; ++i) ty_light_field_destroy(light->beam[i]);
    ty_diffuse_light_destroy(light->diffuse);
    ty_irradiance_cache_destroy(light->cache);
    ty_free_array(light->context, light, 1, sizeof *light);
}

/* ---- images ---- */

void ty_fld_set_march(const ty_fld* light, ty_march_def* march) {
    march->light_box = light->direct_box;
    march->lights = light->lights;
    march->light_count = light->light_count;
    march->reduced = light->reduced;
    march->bilateral_sigma = 0;
    march->preserve_means = true;
}

static ty_result view(ty_volume_call* call, ty_image** out) {
    const ty_fld* light = call->light;
    const ty_camera_def camera = ty_scene_camera(call->scene);
    ty_diffuse_view fields;
    const ty_result made = ty_diffuse_view_make(light->diffuse, call->scene, camera.position, NULL, &fields);
    if (made != TY_OK) {
        ty_diffuse_view_free(&fields);
        return made;
    }
    ty_march_def march = ty_volume_march_def(call);
    ty_fld_set_march(light, &march);
    march.cache = light->cache;
    march.field = &fields.media;
    march.surface_field = &fields.surfaces;
    march.cuts = fields.cuts;
    const ty_result result = ty_march(call->scene, &march, out, NULL);
    ty_diffuse_view_free(&fields);
    return result;
}

/* ---- calls ---- */

/* ty_fld_solve, ty_fld_view and ty_fld_render. */
TY_DEFINE_VOLUME_CALLS(fld);

static void coarsen(void* user, ty_solve_quality quality) {
    ty_fld_def* def = user;
    ty_lower_option(&def->resolution, ty_coarse_bound(quality, 64));
    ty_lower_option(&def->environment_beams, 16);
    ty_lower_option(&def->surface_points, 4);
    def->tolerance = fmax(def->tolerance, 0.01);
}

const ty_volume_method ty_volume_fld = {TY_VOLUME_METHOD(fld),
                                        .solve_fraction = 0.5,
                                        .solve = solve,
                                        .view = view,
                                        .coarsen = coarsen,
                                        .diffuses = true,
                                        .interior_at = offsetof(ty_fld_def, interior_resolution)};
