/* Entry points of the method: solve, view, render, importance. */
#include "base/context.h"
#include "method/diffuse/view.h"
#include "method/pop/job.h"
#include "method/volume_method.h"

#include <string.h>

/* Progress after each stage, as a fraction of the solve. */
static const double medium_until = 0.15, fine_until = 0.3, ordinates_until = 0.7;

/* ---- solving ---- */

static void end_job(ty_pop_job* job) {
    if (job->medium != NULL)
        for (int c = 0; c < 3; ++c) ty_free_array(job->context, job->source[c], job->medium->cells, sizeof(float));
    ty_pop_delta_source_destroy(job->context, &job->delta_source);
    if (job->medium != NULL) ty_incident_flux_free(job->context, job->medium->box.size, &job->incident);
    ty_diffuse_surfaces_destroy(&job->surfaces);
    ty_grid_medium_destroy(job->medium);
    ty_grid_medium_destroy(job->fine);
}

static ty_result allocate_sources(ty_pop_job* job) {
    for (int c = 0; c < 3; ++c) {
        job->source[c] = ty_alloc_array(job->context, job->medium->cells, sizeof(float), true);
        if (job->source[c] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static ty_result run_stages(ty_pop_job* job, double fraction) {
    const double begun = ty_wall_seconds();
    ty_result result = ty_part_next(&job->progress, "media", fraction * medium_until);
    if (result == TY_OK) result = ty_pop_sample_media(job);
    if (result == TY_OK) result = allocate_sources(job);
    job->stats.medium_seconds = ty_wall_seconds() - begun;
    const double incident = ty_wall_seconds();
    if (result == TY_OK) result = ty_part_next(&job->progress, "direct light", fraction * fine_until);
    if (result == TY_OK) result = ty_pop_inject_fine_grid(job);
    job->stats.direct_seconds = ty_wall_seconds() - incident;
    if (result == TY_OK) result = ty_part_next(&job->progress, "ordinates", fraction * ordinates_until);
    if (result == TY_OK) result = ty_pop_light_ordinates(job);
    if (result == TY_OK) result = ty_part_next(&job->progress, "fluence", fraction);
    if (result == TY_OK && job->def->mode == TY_POP_MODE_SPLIT) result = ty_pop_diffuse(job);
    return result;
}

static void get_eye(const ty_scene* scene, float eye[3]) {
    const ty_camera_def camera = ty_scene_camera(scene);
    for (int a = 0; a < 3; ++a) eye[a] = (float)camera.position[a];
}

static ty_result solve(ty_volume_call* call) {
    ty_pop_job job = {.context = call->context,
                      .scene = call->scene,
                      .def = call->def,
                      .progress = call->progress,
                      .light = call->light};
    job.light->context = call->context;
    job.light->def = *job.def;
    get_eye(call->scene, job.light->eye);
    const ty_result result = run_stages(&job, call->fraction);
    memcpy(call->stats, &job.stats, sizeof job.stats);
    end_job(&job);
    return result;
}

void ty_pop_destroy(ty_pop* light) {
    if (light == NULL) return;
    ty_context* context = light->context;
    for (int i = 0; i < TY_POP_FINE_LIGHTS_MAX; ++i)
        for (int f = 0; f < TY_FLUENCE_COUNT; ++f) ty_light_field_destroy(light->fields[i][f]);
    for (int32_t i = 0; i < light->count; ++i)
        ty_free_array(context, light->ordinates[i].lobes, light->ordinates[i].lobe_floats, sizeof(float));
    ty_free_array(context, light->ordinates, (size_t)light->count, sizeof *light->ordinates);
    ty_pop_merged_destroy(context, &light->merged);
    ty_pop_merged_destroy(context, &light->residuum);
    ty_diffuse_light_destroy(light->diffuse);
    ty_irradiance_cache_destroy(light->cache);
    ty_grid_medium_destroy(light->medium);
    ty_free_array(context, light->guide, light->cells, sizeof(float));
    ty_free_array(context, light, 1, sizeof *light);
}

/* ---- images ---- */

/* Source fields of one image. */
typedef struct fields {
    ty_source_field outgoing, surfaces;
    ty_diffuse_view between;         /* between surfaces, from which these fields are; else empty */
    float* terms[3][TY_FIELD_TERMS]; /* of the outgoing radiance */
    float* incident[3];              /* published modes: mean radiance for surfaces */
} fields;

static void free_fields(const ty_pop* light, fields* f) {
    if (f->between.context != NULL) ty_diffuse_view_free(&f->between);
    for (int c = 0; c < 3; ++c) {
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            ty_free_array(light->context, f->terms[c][t], light->cells, sizeof(float));
        ty_free_array(light->context, f->incident[c], light->cells, sizeof(float));
    }
}

/* One term of the outgoing radiance: the diffuse light's, plus in term 0 the ordinates' radiance towards the eye. */
static void fill_term(const ty_pop* light, int c, int t, float* out) {
    if (light->diffuse != NULL) {
        const bool shared = light->diffuse->shared;
        const float* from = light->diffuse->terms[shared ? 0 : c][t];
        const float factor = shared ? light->diffuse->color[c] : 1;
        for (size_t i = 0; i < light->cells; ++i) out[i] = factor * from[i];
    }
    if (t > 0) return;
    for (size_t i = 0; i < light->cells; ++i) out[i] += light->merged.accumulated_radiance[c][i];
    if (light->residuum.accumulated_radiance[c] != NULL)
        for (size_t i = 0; i < light->cells; ++i) out[i] += light->residuum.accumulated_radiance[c][i];
}

static ty_result make_outgoing(const ty_pop* light, fields* f) {
    f->outgoing =
        (ty_source_field){.box = light->merged.box,
                          .term_count = light->diffuse != NULL && !light->diffuse->isotropic ? TY_FIELD_TERMS : 1,
                          .guide = light->guide};
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < f->outgoing.term_count; ++t) {
            f->terms[c][t] = ty_alloc_array(light->context, light->cells, sizeof(float), true);
            if (f->terms[c][t] == NULL) return TY_ERROR_MEMORY;
            fill_term(light, c, t, f->terms[c][t]);
            f->outgoing.terms[c][t] = f->terms[c][t];
        }
    return TY_OK;
}

static ty_result make_incident(const ty_pop* light, fields* f) {
    f->surfaces = (ty_source_field){.box = light->merged.box, .term_count = 1, .guide = light->guide};
    for (int c = 0; c < 3; ++c) {
        f->incident[c] = ty_alloc_array(light->context, light->cells, sizeof(float), true);
        if (f->incident[c] == NULL) return TY_ERROR_MEMORY;
        for (size_t i = 0; i < light->cells; ++i) {
            f->incident[c][i] = light->merged.fluence[c][i] * TY_INV_4PI;
            if (light->residuum.fluence[c] != NULL) f->incident[c][i] += light->residuum.fluence[c][i] * TY_INV_4PI;
        }
        f->surfaces.terms[c][0] = f->incident[c];
    }
    return TY_OK;
}

static ty_result make_between(const ty_pop* light, const ty_scene* scene, fields* f) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const ty_result result =
        ty_diffuse_view_make(light->diffuse, scene, camera.position,
                             light->count > 0 ? light->merged.accumulated_radiance : NULL, &f->between);
    f->outgoing = f->between.media;
    f->surfaces = f->between.surfaces;
    return result;
}

static ty_result make_fields(const ty_pop* light, const ty_scene* scene, fields* f) {
    const bool surfaces = ty_scene_get_view(scene)->mesh != NULL;
    if (light->diffuse != NULL && light->diffuse->faces != NULL) return make_between(light, scene, f);
    if (light->diffuse != NULL) f->surfaces = ty_diffuse_light_field(light->diffuse, true);
    if (light->count == 0 && light->diffuse != NULL) {
        f->outgoing = ty_diffuse_light_field(light->diffuse, surfaces);
        return TY_OK;
    }
    const ty_result result = make_outgoing(light, f);
    return result == TY_OK && light->diffuse == NULL ? make_incident(light, f) : result;
}

void ty_pop_set_march(const ty_pop* light, ty_march_def* march) {
    const bool split = light->def.mode == TY_POP_MODE_SPLIT;
    march->light_box = light->fine_box;
    march->lights = light->lights;
    march->light_count = light->light_count;
    march->reduced = true;
    march->bilateral_sigma = split ? 0 : march->bilateral_sigma; /* otherwise Sec. 4.4 (Elek 2014) */
    march->preserve_means = split;
}

static ty_result march(const ty_pop* light, ty_volume_call* call, ty_image** out) {
    fields f = {.outgoing = {.term_count = 0}};
    ty_march_def march = ty_volume_march_def(call);
    ty_pop_set_march(light, &march);
    march.cache = light->cache;
    march.field = &f.outgoing;
    march.surface_field = &f.surfaces;
    ty_result result = make_fields(light, call->scene, &f);
    march.cuts = f.between.cuts;
    if (result == TY_OK) result = ty_march(call->scene, &march, out, NULL);
    free_fields(light, &f);
    return result;
}

/* Renders from another camera position than the solve's. */
static ty_result march_from(const ty_pop* light, const float eye[3], ty_volume_call* call, ty_image** out) {
    if (!light->def.keep_lobes)
        return ty_fail(
            light->context, TY_ERROR_ARGUMENT,
            "pop: solved for a camera at (%g, %g, %g), and this one is at (%g, %g, %g); keep_lobes is for that",
            (double)light->eye[0], (double)light->eye[1], (double)light->eye[2], (double)eye[0], (double)eye[1],
            (double)eye[2]);
    ty_pop moved;
    ty_result result = ty_pop_move_eye(light, eye, &call->progress, &moved);
    if (result == TY_OK) result = march(&moved, call, out);
    ty_pop_end_view(light, &moved);
    return result;
}

static ty_result view(ty_volume_call* call, ty_image** out) {
    const ty_pop* light = call->light;
    float eye[3];
    get_eye(call->scene, eye);
    const bool same = memcmp(eye, light->eye, sizeof eye) == 0 || light->count == 0;
    return same ? march(light, call, out) : march_from(light, eye, call, out);
}

/* ---- calls ---- */

/* ty_pop_solve, ty_pop_view and ty_pop_render. */
TY_DEFINE_VOLUME_CALLS(pop);

static void free_camera(void* user) {
    ((ty_pop_def*)user)->keep_lobes = true;
}

static void coarsen(void* user, ty_solve_quality quality) {
    ty_pop_def* def = user;
    ty_lower_option(&def->resolution, ty_coarse_bound(quality, 24));
    ty_lower_option(&def->merged, ty_coarse_bound(quality, 32));
    ty_lower_option(&def->direct, ty_coarse_bound(quality, 64));
    ty_lower_option(&def->ordinates, 16);
    ty_lower_option(&def->surface_points, 4);
    ty_lower_option(&def->vpls, 16);
    def->tolerance = fmax(def->tolerance, 0.03);
}

const ty_volume_method ty_volume_pop = {TY_VOLUME_METHOD(pop), .solve_fraction = 0.5,      .solve = solve,
                                        .view = view,          .free_camera = free_camera, .coarsen = coarsen};

/* ---- importance ---- */

ty_result ty_pop_importance(const ty_scene* scene, const ty_pop_def* def, float* map) {
    ty_context* context = ty_scene_context(scene);
    ty_pop_def known;
    ty_result result = ty_volume_take_def(&ty_volume_pop, context, def, &known);
    if (result != TY_OK) return result;
    ty_pop light = {.context = context, .def = known};
    ty_pop_job job = {.context = context, .scene = scene, .def = &known, .light = &light};
    result = ty_scene_check_media(scene, "pop", false);
    if (result == TY_OK) result = ty_pop_sample_media(&job);
    if (result == TY_OK) result = ty_pop_importance_find(scene, &known, light.medium, map);
    ty_grid_medium_destroy(light.medium);
    ty_free_array(context, light.guide, light.cells, sizeof(float));
    end_job(&job);
    return result;
}
