/* Images: radiance that cells scatter towards an eye. */
#include "base/context.h"
#include "base/mapping.h"
#include "base/sh.k.h"
#include "image/march/hidden_cells.h"
#include "method/dom/solution.h"
#include "method/dom/sources/environment.h"
#include "method/dom/sources/sources.h"
#include "method/dom/view/view.h"
#include "scene/scene.h"
#include "solve/angular/harmonics.h"

#include <math.h>
#include <string.h>

enum { TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* Fields for one image. */
typedef struct fields {
    ty_source_field collided, surfaces;
    float* collided_radiance[3];        /* radiance that cells scatter to the eye, per scattering coefficient */
    float* incident[3][TY_FIELD_TERMS]; /* incident radiance for surfaces, as terms of a source field */
    ty_light_fluence lights[TY_DOM_DEDICATED_MAX + 1];
    ty_cuts* cuts;    /* surfaces between cells; NULL: none */
    uint8_t* hidden;  /* state of cells behind surfaces; NULL: none */
    uint8_t* at_face; /* nonzero for diffusive cells that show the eye a face; NULL: none */
    size_t fine_cells;
    float* blurred;               /* environments behind media, with a fit */
    float* aggregate_radiance[3]; /* of fine cells: scattered radiance of lights without dedicated fields, times 4 pi */
} fields;

/* ---- collided radiance ---- */

typedef struct collided_job {
    const ty_dom* light;
    const double* eye;
    float* const* out;
} collided_job;

static void collided_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const collided_job* job = user;
    const ty_dom* light = job->light;
    const int32_t* size = light->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        double omega[3], y[TERMS_MAX];
        ty_dom_direction_to_eye(light, cell, job->eye, omega);
        ty_harmonics_at(omega, light->output_bands, y);
        for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
            const double g = (double)light->g[light->planes == 3 ? c : 0][at];
            const float* surfaces = light->wall_moments[c];
            const float* moments = light->fit.bands > 0 ? light->fit.moments : ty_dom_legendre(light);
            double sum = 0, g_l = 1;
            for (int32_t l = 0; l < light->output_bands; ++l, g_l *= g) {
                const double power = moments != NULL ? (double)moments[l] : g_l;
                for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) {
                    const size_t item = light->cells * (size_t)t + at;
                    sum += power * y[t] * (double)(light->moments[c][item] + (surfaces != NULL ? surfaces[item] : 0));
                }
            }
            job->out[c][at] = (float)sum;
        }
    }
}

static ty_result make_collided(const ty_dom* light, const double eye[3], fields* f) {
    f->collided = (ty_source_field){.box = light->box, .term_count = 1, .shared = light->shared};
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        f->collided_radiance[c] = ty_alloc_large(light->context, light->cells, sizeof(float), false);
        if (f->collided_radiance[c] == NULL) return TY_ERROR_MEMORY;
        f->collided.terms[c][0] = f->collided_radiance[c];
    }
    memcpy(f->collided.color, light->color, sizeof f->collided.color);
    collided_job job = {light, eye, f->collided_radiance};
    ty_parallel_for(light->context, (int64_t)light->box.size[1] * light->box.size[2], collided_row, &job);
    if (light->has_lobes && light->fit.bands == 0) ty_dom_correct_lobes(light, eye, f->collided_radiance);
    if (light->extinction[0] != NULL) {
        f->at_face = ty_alloc_array(light->context, light->cells, 1, true);
        if (f->at_face == NULL) return TY_ERROR_MEMORY;
        f->collided.at_face = f->at_face;
        ty_dom_show_faces(light, f->lights, eye, f->collided_radiance, f->at_face);
    }
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        ty_hidden_cells_fill(light->context, &light->box, f->cuts, f->hidden, f->collided_radiance[c]);
    return TY_OK;
}

/* ---- incident radiance of surfaces ---- */

/* Harmonics of the fluence and of the flux along x, y and z. */
static const int32_t term_of[TY_FIELD_TERMS] = {0, 3, 1, 2};

ty_result ty_dom_make_incident(const ty_dom* light, const uint8_t* hidden, float* incident[3][TY_FIELD_TERMS],
                               ty_source_field* surfaces) {
    *surfaces = (ty_source_field){.box = light->box, .term_count = TY_FIELD_TERMS, .shared = light->shared};
    memcpy(surfaces->color, light->color, sizeof surfaces->color);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            float* out = ty_alloc_array(light->context, light->cells, sizeof(float), false);
            const float* from = ty_dom_plane(light, light->moments[c], term_of[t]);
            const float factor = (float)(t == 0 ? TY_SH_0 : TY_SH_1);
            incident[c][t] = out;
            if (out == NULL) return TY_ERROR_MEMORY;
            for (size_t i = 0; i < light->cells; ++i) out[i] = factor * from[i];
            surfaces->terms[c][t] = out;
        }
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        ty_dom_match_wall_irradiance(light, c, incident[c]);
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            ty_hidden_cells_fill(light->context, &light->box, NULL, hidden, incident[c][t]);
    }
    return TY_OK;
}

/* ---- lights without dedicated fields ---- */

typedef struct aggregate_job {
    const ty_dom* light;
    const ty_light_fluence* uncollided;
    float* const* collided_radiance; /* on coarse cells: scattered radiance of the clusters */
    float* const* fluence;           /* on coarse cells: fluence of the clusters */
    float* const* out;               /* on fine cells */
} aggregate_job;

/* Scales the fine fluence by the clusters' ratio of radiance and fluence. */
static void aggregate_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const aggregate_job* job = user;
    const ty_dom* light = job->light;
    const int32_t *size = light->fine_box.size, *coarse = light->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        float cells[3];
        for (int a = 0; a < 3; ++a) cells[a] = (float)((cell[a] + 0.5) * coarse[a] / size[a]);
        const ty_cell_point point = ty_cell_locate(coarse, ty_vec_load(cells));
        for (int32_t c = 0; c < (job->uncollided->shared != 0 ? 1 : 3); ++c) {
            const float collided_radiance = ty_cell_value(job->collided_radiance[c], &point),
                        fluence = ty_cell_value(job->fluence[c], &point);
            job->out[c][at] =
                fluence > 0 ? ty_maxf(0, collided_radiance / fluence) * job->uncollided->fluence[c][at] : 0;
        }
    }
}

static ty_result allocate_planes(const ty_dom* light, int32_t count, size_t cells, float* planes[3]) {
    for (int32_t c = 0; c < count; ++c) {
        planes[c] = ty_alloc_array(light->context, cells, sizeof(float), false);
        if (planes[c] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static void free_planes(const ty_dom* light, size_t cells, float* const planes[3]) {
    for (int c = 0; c < 3; ++c) ty_free_array(light->context, planes[c], cells, sizeof(float));
}

/* Replaces the P1 fluence of the aggregate field by the radiance towards the eye. */
static ty_result make_aggregate(const ty_dom* light, const double eye[3], ty_part_progress* progress, fields* f) {
    ty_light_fluence* uncollided = &f->lights[light->fluence_count - 1];
    const int32_t channels = uncollided->shared != 0 ? 1 : 3;
    float *collided_radiance[3] = {NULL}, *fluence[3] = {NULL};
    ty_result result = allocate_planes(light, channels, f->fine_cells, f->aggregate_radiance);
    if (result == TY_OK) result = allocate_planes(light, channels, light->cells, collided_radiance);
    if (result == TY_OK) result = allocate_planes(light, channels, light->cells, fluence);
    if (result == TY_OK) result = ty_dom_evaluate_clusters(light, eye, channels, progress, collided_radiance, fluence);
    if (result == TY_OK) {
        aggregate_job job = {light, uncollided, collided_radiance, fluence, f->aggregate_radiance};
        ty_parallel_for(light->context, (int64_t)light->fine_box.size[1] * light->fine_box.size[2], aggregate_row,
                        &job);
        for (int32_t c = 0; c < channels; ++c) uncollided->fluence[c] = f->aggregate_radiance[c];
    }
    free_planes(light, light->cells, collided_radiance);
    free_planes(light, light->cells, fluence);
    return result;
}

static ty_result make_lights(const ty_dom* light, const double eye[3], ty_part_progress* progress, fields* f) {
    memcpy(f->lights, light->fluences, sizeof f->lights);
    if (light->aggregate == NULL) return TY_OK;
    f->lights[light->fluence_count - 1].kind = TY_FLUENCE_ISOTROPIC;
    return light->isotropic ? TY_OK : make_aggregate(light, eye, progress, f);
}

/* The environments' radiance through a fit's peak. */
static ty_result make_blurred(const ty_dom* light, fields* f) {
    if (light->fit.bands == 0 || light->env_count == 0) return TY_OK;
    f->blurred = ty_alloc_array(light->context, TY_DOM_ENVIRONMENT_TEXELS, 3 * sizeof(float), false);
    if (f->blurred == NULL) return TY_ERROR_MEMORY;
    ty_dom_environment_blur(light, f->blurred);
    return TY_OK;
}

/* ---- images ---- */

static void free_fields(const ty_dom* light, fields* f) {
    ty_cuts_destroy(f->cuts);
    ty_free_array(light->context, f->hidden, light->cells, 1);
    ty_free_array(light->context, f->at_face, light->cells, 1);
    ty_free_array(light->context, f->blurred, TY_DOM_ENVIRONMENT_TEXELS, 3 * sizeof(float));
    for (int c = 0; c < 3; ++c) {
        ty_free_large(light->context, f->collided_radiance[c], light->cells, sizeof(float));
        ty_free_array(light->context, f->aggregate_radiance[c], f->fine_cells, sizeof(float));
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            ty_free_array(light->context, f->incident[c][t], light->cells, sizeof(float));
    }
}

static ty_result make_fields(ty_volume_call* call, const double eye[3], fields* f) {
    const ty_dom* light = call->light;
    const bool surfaces = ty_scene_get_view(call->scene)->mesh != NULL;
    const int32_t* fine = light->fine_box.size;
    f->fine_cells = (size_t)fine[0] * (size_t)fine[1] * (size_t)fine[2];
    ty_result result = ty_cuts_find(light->context, light->boundary, &light->box, &f->cuts);
    if (result == TY_OK && light->unlit != NULL)
        result = ty_hidden_cells_find(light->context, call->scene, &light->box, eye, &f->hidden);
    if (result == TY_OK) result = make_lights(light, eye, &call->progress, f);
    if (result == TY_OK) result = make_collided(light, eye, f);
    if (result == TY_OK && surfaces) result = ty_dom_make_incident(light, f->hidden, f->incident, &f->surfaces);
    if (result == TY_OK) result = make_blurred(light, f);
    return result;
}

void ty_dom_set_march(const ty_dom* light, ty_march_def* march) {
    march->light_box = light->fine_box;
    march->light_count = light->fluence_count;
    march->reduced = light->bands;
    march->legendre = ty_dom_legendre(light);
    march->fit = light->fit.bands > 0 ? &light->fit : NULL;
    march->bilateral_sigma = 0;
    march->preserve_means = true;
    march->edge_rays = 32;
}

ty_result ty_dom_march(ty_volume_call* call, ty_image** out) {
    const ty_dom* light = call->light;
    const ty_camera_def camera = ty_scene_camera(call->scene);
    const bool surfaces = ty_scene_get_view(call->scene)->mesh != NULL;
    fields f = {.fine_cells = 0};
    ty_march_def march = ty_volume_march_def(call);
    ty_dom_set_march(light, &march);
    march.lights = f.lights;
    march.cache = light->cache;
    march.field = &f.collided;
    march.surface_field = surfaces ? &f.surfaces : NULL;
    ty_result result = make_fields(call, camera.position, &f);
    march.cuts = f.cuts;
    march.blurred = f.blurred;
    march.traces_faces = true;
    if (result == TY_OK) result = ty_march(call->scene, &march, out, NULL);
    free_fields(light, &f);
    return result;
}
