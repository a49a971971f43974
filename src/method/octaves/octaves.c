/* Multiple scattering octaves: entry points. */
#include "method/octaves/job.h"

#include "base/context.h"
#include "image/march/froxels.h"
#include "method/volume_method.h"

#include <math.h>
#include <string.h>

/* Fraction of a solve's progress after sampling the media. */
static const double medium_until = 0.2;

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

TY_DEFINE_RUN_STAGE(ty_octaves_job);

static ty_result solve(ty_volume_call* call) {
    ty_octaves_job job = {.context = call->context,
                          .scene = call->scene,
                          .def = call->def,
                          .progress = call->progress,
                          .light = call->light};
    job.light->context = call->context;
    job.light->octaves = ty_octaves_of(job.def);
    ty_result result = run_stage(&job, "media", call->fraction * medium_until, sample_media, &job.stats.medium_seconds);
    if (result == TY_OK)
        result = run_stage(&job, "direct light", call->fraction, ty_octaves_light, &job.stats.direct_seconds);
    memcpy(call->stats, &job.stats, sizeof job.stats);
    ty_grid_medium_destroy(job.medium);
    return result;
}

void ty_octaves_destroy(ty_octaves* light) {
    if (light == NULL) return;
    for (int32_t i = 0; i < TY_OCTAVES_MAX; ++i)
        for (int32_t l = 0; l < TY_OCTAVES_LIGHTS_MAX; ++l) ty_light_field_destroy(light->fields[i][l]);
    ty_free_array(light->context, light, 1, sizeof *light);
}

/* ---- images ---- */

/* Rows of froxels that are as high as wide. */
static void set_froxels(const ty_octaves_def* def, ty_march_def* march) {
    if (def->froxels == 0) return;
    const double rows = round((double)def->froxels * march->height / march->width);
    march->froxels[0] = def->froxels;
    march->froxels[1] = (int32_t)fmax(1, fmin(rows, TY_FROXEL_ROWS_MAX));
    march->froxels[2] = def->froxel_slices;
}

static ty_result view(ty_volume_call* call, ty_image** out) {
    const ty_octaves* light = call->light;
    ty_march_octaves octaves = light->octaves;
    octaves.lights = light->lights + light->light_count;
    ty_march_def march = ty_volume_march_def(call);
    march.light_box = light->box;
    march.lights = light->lights;
    march.light_count = light->light_count;
    march.octaves = &octaves;
    set_froxels(call->def, &march);
    return ty_march(call->scene, &march, out, NULL);
}

/* ---- calls ---- */

/* ty_octaves_solve, ty_octaves_view and ty_octaves_render. */
TY_DEFINE_VOLUME_CALLS(octaves);

static void coarsen(void* user, ty_solve_quality quality) {
    ty_octaves_def* def = user;
    ty_lower_option(&def->resolution, ty_coarse_bound(quality, 64));
    ty_lower_option(&def->environment_beams, 16);
    ty_lower_option(&def->surface_points, 4);
}

const ty_volume_method ty_volume_octaves = {
    TY_VOLUME_METHOD(octaves), .solve_fraction = 0.4, .check = ty_octaves_check_scales, .solve = solve, .view = view,
    .coarsen = coarsen};
