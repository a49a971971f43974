/* Images: what cells send towards an eye. */
#include "base/context.h"
#include "image/march.h"
#include "method/dom/job.h"
#include "method/dom/sky.h"
#include "scene/scene.h"
#include "solve/angular/harmonics.h"

#include <math.h>
#include <string.h>

enum { TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

static const double harmonic_0 = 0.28209479177387814, harmonic_1 = 0.4886025119029199;

/* Fields that are made for one image. */
typedef struct fields {
    ty_source_field seen, surfaces;
    float* sent[3];                     /* radiance that cells send to the eye per scattering coefficient */
    float* incident[3][TY_FIELD_TERMS]; /* radiance by direction, for surfaces */
    ty_single_light lights[TY_DOM_OWN_MAX + 1];
    ty_cuts* cuts;   /* surfaces between cells; NULL: there are none */
    uint8_t* hidden; /* cells behind surfaces; NULL: there are none */
    size_t fine_cells;
    float* blurred; /* environments behind media, with a fit */
    float* many[3]; /* of fine cells: what lights without fields of their own send to the eye, times 4 pi */
} fields;

/* ---- what cells send ---- */

typedef struct send_job {
    const ty_dom* light;
    const double* eye;
    float* const* out;
} send_job;

void ty_dom_way(const ty_dom* light, const int32_t cell[3], const double eye[3], double way[3]) {
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        const double side = (light->box.upper[a] - light->box.lower[a]) / light->box.size[a];
        way[a] = eye[a] - (light->box.lower[a] + (cell[a] + 0.5) * side);
        square += way[a] * way[a];
    }
    for (int a = 0; a < 3; ++a) way[a] = square > 0 ? way[a] / sqrt(square) : a == 2;
}

/* Of the fluence that a thick cell's faces show an eye, what it is more than the cell's mean. */
static double seen_more(const ty_dom* light, int32_t channel, size_t cell, const double way[3]) {
    double sum = 0, weights = 0;
    if (light->seen[channel] == NULL) return 0;
    for (int face = 0; face < 6; ++face) {
        const double seen = (double)light->seen[channel][6 * cell + (size_t)face];
        const double weight = (face & 1) != 0 ? way[face / 2] : -way[face / 2];
        if (seen < 0 || weight <= 0) continue;
        sum += weight * seen;
        weights += weight;
    }
    return weights > 0 ? sum / weights - (double)light->moments[channel][cell] : 0;
}

static void send_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const send_job* job = user;
    const ty_dom* light = job->light;
    const int32_t* size = light->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        double way[3], y[TERMS_MAX];
        ty_dom_way(light, cell, job->eye, way);
        ty_harmonics_at(way, light->kept, y);
        for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
            const double g = (double)light->g[light->planes == 3 ? c : 0][at];
            const float* surfaces = light->surfaces[c];
            const ty_forward_fit* fit = light->fit.bands > 0 ? &light->fit : NULL;
            double sum = y[0] * seen_more(light, c, at, way) * (fit != NULL ? (double)fit->moments[0] : 1), of_g = 1;
            for (int32_t l = 0; l < light->kept; ++l, of_g *= g) {
                const double power = fit != NULL ? (double)fit->moments[l] : of_g;
                for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) {
                    const size_t item = light->cells * (size_t)t + at;
                    sum += power * y[t] * (double)(light->moments[c][item] + (surfaces != NULL ? surfaces[item] : 0));
                }
            }
            job->out[c][at] = (float)sum;
        }
    }
}

static ty_result make_seen(const ty_dom* light, const double eye[3], fields* f) {
    f->seen = (ty_source_field){.box = light->box, .term_count = 1, .shared = light->shared};
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        f->sent[c] = ty_alloc_array(light->context, light->cells, sizeof(float), false);
        if (f->sent[c] == NULL) return TY_ERROR_MEMORY;
        f->seen.terms[c][0] = f->sent[c];
    }
    memcpy(f->seen.color, light->color, sizeof f->seen.color);
    send_job job = {light, eye, f->sent};
    ty_parallel_for(light->context, (int64_t)light->box.size[1] * light->box.size[2], send_row, &job);
    if (light->lobes && light->fit.bands == 0) ty_dom_mend_lobes(light, eye, f->sent);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) ty_dom_cover_hidden(light, f->cuts, f->hidden, f->sent[c]);
    return TY_OK;
}

/* ---- what surfaces get ---- */

/* Harmonics of radiance along x, y and z. */
static const int32_t term_of[TY_FIELD_TERMS] = {0, 3, 1, 2};

static ty_result make_incident(const ty_dom* light, fields* f) {
    f->surfaces = (ty_source_field){.box = light->box, .term_count = TY_FIELD_TERMS, .shared = light->shared};
    memcpy(f->surfaces.color, light->color, sizeof f->surfaces.color);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            float* out = ty_alloc_array(light->context, light->cells, sizeof(float), false);
            const float* from = ty_dom_plane(light, light->moments[c], term_of[t]);
            const float factor = (float)(t == 0 ? harmonic_0 : harmonic_1);
            f->incident[c][t] = out;
            if (out == NULL) return TY_ERROR_MEMORY;
            for (size_t i = 0; i < light->cells; ++i) out[i] = factor * from[i];
            f->surfaces.terms[c][t] = out;
        }
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        ty_dom_turn_to_walls(light, c, f->incident[c]);
        for (int t = 0; t < TY_FIELD_TERMS; ++t) ty_dom_cover_hidden(light, NULL, f->hidden, f->incident[c][t]);
    }
    return TY_OK;
}

/* ---- lights that have no field of their own ---- */

typedef struct many_job {
    const ty_dom* light;
    const ty_single_light* single;
    float* const* sent; /* of the cells of ordinates: what such light is turned into for the eye */
    float* const* all;  /* and how much of it there is */
    float* const* out;  /* of fine cells */
} many_job;

/* Their fluence on fine cells, times what becomes of it on the cells of ordinates. */
static void many_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const many_job* job = user;
    const ty_dom* light = job->light;
    const int32_t *size = light->fine_box.size, *coarse = light->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        float cells[3];
        for (int a = 0; a < 3; ++a) cells[a] = (float)((cell[a] + 0.5) * coarse[a] / size[a]);
        const ty_cell_point place = ty_cell_locate(coarse, ty_vec_load(cells));
        for (int32_t c = 0; c < (job->single->shared != 0 ? 1 : 3); ++c) {
            const float sent = ty_cell_value(job->sent[c], &place), all = ty_cell_value(job->all[c], &place);
            job->out[c][at] = all > 0 ? ty_maxf(0, sent / all) * job->single->fluence[c][at] : 0;
        }
    }
}

static ty_result take_planes(const ty_dom* light, int32_t count, size_t cells, float* planes[3]) {
    for (int32_t c = 0; c < count; ++c) {
        planes[c] = ty_alloc_array(light->context, cells, sizeof(float), false);
        if (planes[c] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static void free_planes(const ty_dom* light, size_t cells, float* const planes[3]) {
    for (int c = 0; c < 3; ++c) ty_free_array(light->context, planes[c], cells, sizeof(float));
}

/* Fields of fine cells in place of those of TY_SINGLE_MANY, which know no direction. */
static ty_result make_many(const ty_dom* light, const double eye[3], fields* f) {
    ty_single_light* single = &f->lights[light->light_count - 1];
    const int32_t channels = single->shared != 0 ? 1 : 3;
    float *sent[3] = {NULL}, *all[3] = {NULL};
    ty_result result = take_planes(light, channels, f->fine_cells, f->many);
    if (result == TY_OK) result = take_planes(light, channels, light->cells, sent);
    if (result == TY_OK) result = take_planes(light, channels, light->cells, all);
    if (result == TY_OK) result = ty_dom_send_parts(light, eye, channels, sent, all);
    if (result == TY_OK) {
        many_job job = {light, single, sent, all, f->many};
        ty_parallel_for(light->context, (int64_t)light->fine_box.size[1] * light->fine_box.size[2], many_row, &job);
        for (int32_t c = 0; c < channels; ++c) single->fluence[c] = f->many[c];
    }
    free_planes(light, light->cells, sent);
    free_planes(light, light->cells, all);
    return result;
}

static ty_result make_lights(const ty_dom* light, const double eye[3], fields* f) {
    memcpy(f->lights, light->lights, sizeof f->lights);
    if (light->many == NULL) return TY_OK;
    f->lights[light->light_count - 1].kind = TY_SINGLE_EVEN;
    return light->even ? TY_OK : make_many(light, eye, f);
}

/* What of environments is seen through a fit's peak. */
static ty_result make_blurred(const ty_dom* light, fields* f) {
    if (light->fit.bands == 0 || light->piece_count == 0) return TY_OK;
    f->blurred = ty_alloc_array(light->context, TY_DOM_SKY_TEXELS, 3 * sizeof(float), false);
    if (f->blurred == NULL) return TY_ERROR_MEMORY;
    ty_dom_sky_blur(light, f->blurred);
    return TY_OK;
}

/* ---- images ---- */

static void free_fields(const ty_dom* light, fields* f) {
    ty_cuts_destroy(f->cuts);
    ty_free_array(light->context, f->hidden, light->cells, 1);
    ty_free_array(light->context, f->blurred, TY_DOM_SKY_TEXELS, 3 * sizeof(float));
    for (int c = 0; c < 3; ++c) {
        ty_free_array(light->context, f->sent[c], light->cells, sizeof(float));
        ty_free_array(light->context, f->many[c], f->fine_cells, sizeof(float));
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            ty_free_array(light->context, f->incident[c][t], light->cells, sizeof(float));
    }
}

static ty_result make_fields(const ty_dom* light, const ty_scene* scene, const double eye[3], fields* f) {
    const bool surfaces = ty_scene_get_view(scene)->mesh != NULL;
    const int32_t* fine = light->fine_box.size;
    f->fine_cells = (size_t)fine[0] * (size_t)fine[1] * (size_t)fine[2];
    ty_result result = ty_cuts_find(light->context, light->walls, &light->box, &f->cuts);
    if (result == TY_OK) result = ty_dom_look(light, scene, eye, &f->hidden);
    if (result == TY_OK) result = make_seen(light, eye, f);
    if (result == TY_OK && surfaces) result = make_incident(light, f);
    if (result == TY_OK) result = make_lights(light, eye, f);
    if (result == TY_OK) result = make_blurred(light, f);
    return result;
}

ty_result ty_dom_march(const ty_dom* light, const ty_scene* scene, const ty_dom_def* def, ty_part_progress progress,
                       ty_image** out, ty_dom_stats* stats) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const ty_image_options options = ty_dom_image_options(def);
    const bool surfaces = ty_scene_get_view(scene)->mesh != NULL;
    const double begun = ty_wall_seconds();
    fields f = {.fine_cells = 0};
    ty_march_def march = ty_march_def_of(scene, &options);
    march.light_box = light->fine_box;
    march.lights = f.lights;
    march.light_count = light->light_count;
    march.reduced = light->bands;
    march.fit = light->fit.bands > 0 ? &light->fit : NULL;
    march.field = &f.seen;
    march.surface_field = surfaces ? &f.surfaces : NULL;
    march.guided = 0;
    march.keeps_means = true;
    march.unscattered = def->unscattered;
    march.progress = ty_part_report;
    march.progress_user = &progress;
    ty_march_stats marched = {0};
    ty_result result = make_fields(light, scene, camera.position, &f);
    march.cuts = f.cuts;
    march.blurred = f.blurred;
    if (result == TY_OK) result = ty_march(scene, &march, out, &marched);
    free_fields(light, &f);
    if (result == TY_OK && stats != NULL) {
        stats->march_seconds = ty_wall_seconds() - begun;
        stats->seconds += stats->march_seconds;
        stats->isa = marched.isa;
    }
    return result;
}
