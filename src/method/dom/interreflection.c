/* Interreflection of media with surfaces outside of their box. Light that returns from these is solved as light that
 * enters the box; its first return stands for all further ones, which are in proportion. */
#include "base/constants.h"
#include "base/context.h"
#include "base/mapping.h"
#include "base/sh.k.h"
#include "method/dom/solve/solve.h"
#include "method/dom/view/view.h"
#include "method/diffuse/interreflection.h"

#include <string.h>

/* Tolerance of the solve of what returns relative to that of the solve before. */
static const double TOLERANCE = 3;

/* ---- light of media at surfaces ---- */

/* Fields that surfaces see from all sides: the first two moments of the cells. */
typedef struct fields {
    ty_source_field media, surfaces;
    float *terms[3][TY_FIELD_TERMS], *incident[3][TY_FIELD_TERMS];
    ty_light_fluence lights[TY_DOM_DEDICATED_MAX + 1];
    ty_cuts* cuts;
} fields;

/* Mean excess of the exposed faces of a diffusive cell over its fluence, which are what is seen of it. */
static float face_excess(const ty_dom* light, int32_t channel, size_t cell) {
    const float* faces = light->face_fluence[channel];
    float sum = 0;
    int32_t count = 0;
    for (size_t face = 0; face < 6 && faces != NULL; ++face) {
        if (faces[6 * cell + face] < 0) continue;
        sum += faces[6 * cell + face];
        ++count;
    }
    return count > 0 ? sum / (float)count - light->moments[channel][cell] : 0;
}

static ty_result make_media(const ty_dom* light, fields* f) {
    static const int32_t term_of[TY_FIELD_TERMS] = {0, 3, 1, 2};
    f->media = (ty_source_field){.box = light->box, .term_count = TY_FIELD_TERMS, .shared = light->shared};
    memcpy(f->media.color, light->color, sizeof f->media.color);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            float* out = ty_alloc_array(light->context, light->cells, sizeof(float), false);
            const bool moment_exists = term_of[t] < light->output_bands * light->output_bands;
            const size_t first = light->cells * (size_t)term_of[t];
            const float factor = (float)(t == 0 ? TY_SH_0 : TY_SH_1);
            f->terms[c][t] = out;
            if (out == NULL) return TY_ERROR_MEMORY;
            for (size_t i = 0; i < light->cells; ++i) {
                float moment = moment_exists ? light->moments[c][first + i] : 0;
                if (moment_exists && light->wall_moments[c] != NULL) moment += light->wall_moments[c][first + i];
                out[i] = factor * (moment + (t == 0 ? face_excess(light, c, i) : 0));
            }
            f->media.terms[c][t] = out;
        }
    return TY_OK;
}

static void free_fields(const ty_dom* light, fields* f) {
    ty_cuts_destroy(f->cuts);
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            ty_free_array(light->context, f->terms[c][t], light->cells, sizeof(float));
            ty_free_array(light->context, f->incident[c][t], light->cells, sizeof(float));
        }
}

static ty_result gather(const ty_dom_job* job, const ty_dom* light, ty_reflected_light which) {
    const bool more = which == TY_REFLECTED_MORE;
    fields f = {.cuts = NULL};
    ty_march_def march = ty_default_march_def();
    ty_dom_set_march(light, &march);
    memcpy(f.lights, light->fluences, sizeof f.lights);
    if (light->aggregate != NULL) f.lights[light->fluence_count - 1].kind = TY_FLUENCE_ISOTROPIC;
    march.width = march.height = 1;
    march.step = job->def->step;
    march.lights = f.lights;
    march.light_count = more ? 0 : light->fluence_count;
    march.field = &f.media;
    march.surface_field = &f.surfaces;
    ty_result result = ty_cuts_find(light->context, light->boundary, &light->box, &f.cuts);
    march.cuts = f.cuts;
    if (result == TY_OK) result = make_media(light, &f);
    if (result == TY_OK) result = ty_dom_make_incident(light, NULL, f.incident, &f.surfaces);
    if (result == TY_OK) result = ty_irradiance_cache_gather(job->light->cache, job->scene, &march, !more, which);
    free_fields(light, &f);
    return result;
}

/* ---- what returns ---- */

/* A solution like the light, of nothing yet. */
static ty_result begin_more(const ty_dom* light, ty_dom* more) {
    *more = *light;
    const size_t sides = light->boundary != NULL ? (size_t)light->boundary->count : 0;
    for (int c = 0; c < 3; ++c)
        more->moments[c] = more->face_fluence[c] = more->face_even[c] = more->wall_moments[c] = NULL;
    for (int c = 0; c < 3; ++c) {
        more->wall_irradiance[c] = sides > 0 ? ty_alloc_array(light->context, sides, sizeof(float), true) : NULL;
        more->wall_forward[c] = sides > 0 ? ty_alloc_array(light->context, sides, sizeof(float), true) : NULL;
    }
    for (int c = 0; c < 3 && sides > 0; ++c)
        if (more->wall_irradiance[c] == NULL || more->wall_forward[c] == NULL) return TY_ERROR_MEMORY;
    return TY_OK;
}

static void end_more(ty_dom* more) {
    const size_t bytes = (size_t)more->output_bands * (size_t)more->output_bands * sizeof(float);
    const size_t sides = more->boundary != NULL ? (size_t)more->boundary->count : 0;
    for (int c = 0; c < 3; ++c) {
        ty_free_large(more->context, more->moments[c], more->cells, bytes);
        if (more->face_fluence[c] != NULL)
            ty_free_array(more->context, more->face_fluence[c], 6 * more->cells, sizeof(float));
        if (more->face_even[c] != NULL)
            ty_free_array(more->context, more->face_even[c], 6 * more->cells, sizeof(float));
        ty_free_large(more->context, more->wall_moments[c], more->cells, bytes);
        ty_free_array(more->context, more->wall_irradiance[c], sides, sizeof(float));
        ty_free_array(more->context, more->wall_forward[c], sides, sizeof(float));
    }
}

/* Solves for the light that enters the box, which is all there is. */
static ty_result solve_more(ty_dom_job* job, ty_dom* more, ty_dom_stats* stats) {
    const size_t terms = (size_t)(more->bands * more->bands);
    const size_t sides = more->boundary != NULL ? (size_t)more->boundary->count : 0;
    ty_dom_def def = *job->def;
    ty_dom_job returned = *job;
    float* dark = sides > 0 ? ty_alloc_array(job->context, sides, sizeof *dark, true) : NULL;
    ty_result result = sides > 0 && dark == NULL ? TY_ERROR_MEMORY : TY_OK;
    def.start = NULL;
    def.tolerance = def.tolerance * TOLERANCE < 1 ? def.tolerance * TOLERANCE : def.tolerance;
    returned.def = &def;
    returned.light = more;
    returned.stats = ty_default_dom_stats();
    for (int c = 0; c < 3; ++c) {
        returned.source[c] = returned.centers[c] = returned.incident_radiance[c] = NULL;
        returned.wall_radiance[c] = dark;
    }
    for (int32_t c = 0; c < ty_dom_channels(more) && result == TY_OK; ++c) {
        returned.source[c] = ty_alloc_large(job->context, more->cells, terms * sizeof(float), true);
        if (returned.source[c] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) result = ty_dom_find_returned_radiance(&returned, returned.incident_radiance);
    if (result == TY_OK) result = ty_dom_solve_channels(&returned);
    for (int c = 0; c < 3; ++c) {
        ty_free_large(job->context, returned.source[c], more->cells, terms * sizeof(float));
        ty_free_array(job->context, returned.incident_radiance[c], ty_dom_incident_floats(job), sizeof(float));
    }
    ty_free_array(job->context, dark, sides, sizeof *dark);
    job->progress = returned.progress;
    *stats = returned.stats;
    return result;
}

/* Adds to what faces show. */
static void add_faces(ty_dom* light, ty_dom* more, int32_t c, float factor) {
    const float* walls = more->wall_moments[c];
    if (more->face_fluence[c] == NULL) return;
    const bool first = light->face_fluence[c] == NULL;
    if (first) {
        light->face_fluence[c] = more->face_fluence[c];
        light->face_even[c] = more->face_even[c];
    }
    for (size_t i = 0; i < 6 * light->cells; ++i) {
        if (light->face_fluence[c][i] < 0) continue;
        const float shown = factor * (more->face_fluence[c][i] + (walls != NULL ? walls[i / 6] : 0));
        const float even = factor * (more->face_even[c][i] + (walls != NULL ? walls[i / 6] : 0));
        light->face_fluence[c][i] = first ? shown : light->face_fluence[c][i] + shown;
        light->face_even[c][i] = first ? even : light->face_even[c][i] + even;
    }
    if (first) more->face_fluence[c] = more->face_even[c] = NULL;
}

/* Adds factor times what returns. Its light without a collision since counts as collided, since media have scattered
 * it. */
static void add_channel(ty_dom* light, ty_dom* more, int32_t c, float factor) {
    const size_t terms = (size_t)(light->output_bands * light->output_bands);
    const size_t sides = light->boundary != NULL ? (size_t)light->boundary->count : 0;
    const float* walls = more->wall_moments[c];
    add_faces(light, more, c, factor);
    for (size_t i = 0; i < terms * light->cells; ++i)
        light->moments[c][i] += factor * (more->moments[c][i] + (walls != NULL ? walls[i] : 0));
    for (size_t i = 0; i < sides && light->wall_irradiance[c] != NULL; ++i)
        light->wall_irradiance[c][i] += factor * more->wall_irradiance[c][i];
}

static void add_stats(ty_dom_stats* stats, const ty_dom_stats* more, double factor) {
    stats->converged = stats->converged && more->converged;
    stats->sweep_seconds += more->sweep_seconds;
    for (int c = 0; c < 3; ++c) {
        stats->sweeps[c] += more->sweeps[c];
        stats->cycles[c] += more->cycles[c];
        stats->emitted[c] += factor * more->emitted[c];
        stats->absorbed[c] += factor * more->absorbed[c];
        stats->absorbed_by_surfaces[c] += factor * more->absorbed_by_surfaces[c];
        stats->leaving[c] += factor * more->leaving[c];
    }
}

ty_result ty_dom_interreflect(ty_dom_job* job) {
    ty_dom *light = job->light, more;
    ty_irradiance_cache* cache = light->cache;
    ty_dom_stats stats;
    if (cache == NULL || !job->def->interreflection) return TY_OK;
    ty_result result = gather(job, light, TY_REFLECTED_MEDIA);
    const double emitted = job->stats.emitted[0] + job->stats.emitted[1] + job->stats.emitted[2];
    if (result != TY_OK || ty_irradiance_cache_power(cache, TY_REFLECTED_MEDIA) < TY_INTERREFLECTION_MIN * emitted)
        return result;
    result = begin_more(light, &more);
    if (result == TY_OK) result = solve_more(job, &more, &stats);
    if (result == TY_OK) result = gather(job, &more, TY_REFLECTED_MORE);
    if (result == TY_OK) {
        const double series = ty_interreflection_series(cache);
        for (int32_t c = 0; c < ty_dom_channels(light); ++c) add_channel(light, &more, c, (float)series);
        ty_irradiance_cache_add_more(cache, series);
        add_stats(&job->stats, &stats, series);
    }
    end_more(&more);
    return result;
}
