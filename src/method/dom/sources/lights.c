/* Beams and lamps of all lights. */
#include "base/context.h"
#include "direct/lights/environment_clusters.h"
#include "direct/lights/vpl.h"
#include "method/dom/job.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Relative difference up to which colors are multiples of each other. */
static const float alike = 1e-6f;

/* ---- colors ---- */

static bool is_black(const float color[3]) {
    return !(color[0] + color[1] + color[2] > 0);
}

/* A color that all emission may be a multiple of; black where nothing glows. */
static void emission_color(const ty_grid_medium* medium, float color[3]) {
    for (int c = 0; c < 3; ++c) color[c] = 0;
    for (size_t i = 0; i < medium->cells && is_black(color); ++i)
        for (int c = 0; c < 3; ++c) color[c] = medium->emission[c] != NULL ? medium->emission[c][i] : 0;
}

static bool emission_shares(const ty_grid_medium* medium, const float color[3]) {
    for (int c = 0; c < 3 && medium->emission[0] != NULL; ++c) {
        const int d = (c + 1) % 3;
        for (size_t i = 0; i < medium->cells; ++i) {
            const float a = medium->emission[c][i] * color[d], b = medium->emission[d][i] * color[c];
            if (fabsf(a - b) > alike * ty_maxf(a, b)) return false;
        }
    }
    return true;
}

/* ---- sources ---- */

static bool is_environment(const ty_light_set* lights, int32_t light) {
    return lights->lights[light].kind == TY_KIND_ENVIRONMENT;
}

/* Beams of an environment light: parts that it is cut into, so that nothing of it is left out. */
static ty_result add_environment(ty_dom_job* job, int32_t light, ty_light_part* parts) {
    const ty_environment_parts_def def = {.parts = job->def->environment_beams, .prefilter = 1, .seed = job->def->seed};
    int32_t count = 0;
    const ty_result result = ty_environment_parts(job->scene, &def, light, parts, &count);
    for (int32_t i = 0; i < count && result == TY_OK; ++i) {
        ty_source* source = &job->sources[job->source_count++];
        *source = (ty_source){
            .kind = TY_SOURCE_BEAM, .light = light, .direction = parts[i].direction, .cosine = parts[i].cosine};
        memcpy(source->color, parts[i].color, sizeof source->color);
    }
    return result;
}

static ty_result add_environments(ty_dom_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    const size_t beams = (size_t)job->def->environment_beams;
    ty_light_part* parts = ty_alloc_array(job->context, beams, sizeof *parts, false);
    ty_result result = parts != NULL ? TY_OK : TY_ERROR_MEMORY;
    for (int32_t i = 0; i < lights->count && result == TY_OK; ++i)
        if (is_environment(lights, i)) result = add_environment(job, i, parts);
    ty_free_array(job->context, parts, beams, sizeof *parts);
    return result;
}

/* What surfaces that are no walls send back of directional, point and spot lights: so many lamps at most. */
enum { REFLECTIONS = 32 };

static const ty_light_view reflection = {.kind = TY_KIND_AREA};

static ty_result find_reflections(const ty_dom_job* job, ty_light_part** out, int32_t* count) {
    ty_vpl_def def = ty_default_vpl_def();
    def.count = REFLECTIONS;
    def.seed = job->def->seed;
    /* Walls send what ordinates bring themselves; other surfaces are lit by what of it goes on about straight. */
    if (job->walls != NULL) def.reduced = job->light->bands;
    return ty_vpls_create(job->scene, &def, job->coarse, out, count);
}

static void add_reflections(ty_dom_job* job, const ty_light_part* lamps, int32_t count) {
    for (int32_t i = 0; i < count; ++i) {
        ty_source* source = &job->sources[job->source_count];
        *source = (ty_source){.kind = TY_SOURCE_LAMP,
                              .light = lamps[i].light,
                              .direction = lamps[i].direction,
                              .position = lamps[i].position,
                              .stand_in = &reflection,
                              .area = lamps[i].least * lamps[i].least,
                              .cosine = 1};
        memcpy(source->color, lamps[i].color, sizeof source->color);
        if (!is_black(source->color) && !ty_dom_is_walled(job, source->position)) ++job->source_count;
    }
}

/* What is not black of all lights but environments. */
static void add_others(ty_dom_job* job, const ty_source* sources, int32_t count) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    for (int32_t i = 0; i < count; ++i)
        if (!is_environment(lights, sources[i].light) && !is_black(sources[i].color))
            job->sources[job->source_count++] = sources[i];
}

static ty_result take_sources(ty_dom_job* job, int32_t others) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    int64_t capacity = others;
    for (int32_t i = 0; i < lights->count; ++i)
        if (is_environment(lights, i)) capacity += job->def->environment_beams;
    if (capacity > INT32_MAX)
        return ty_fail(job->context, TY_ERROR_ARGUMENT, "dom: %lld beams and lamps", (long long)capacity);
    job->sources = ty_alloc_array(job->context, (size_t)capacity, sizeof *job->sources, false);
    job->source_capacity = (int32_t)capacity;
    return job->sources != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result make_sources(ty_dom_job* job) {
    const ty_source_def def = {.environment = 1, .surface = job->def->surface_points, .seed = job->def->seed};
    ty_source* sources = NULL;
    ty_light_part* reflected = NULL;
    int32_t count = 0, reflected_count = 0;
    ty_result result = ty_sources_create(job->scene, &def, &sources, &count);
    if (result != TY_OK) return result;
    if (ty_scene_get_view(job->scene)->mesh != NULL) result = find_reflections(job, &reflected, &reflected_count);
    if (result == TY_OK) result = take_sources(job, count + reflected_count);
    if (result == TY_OK) {
        add_others(job, sources, count);
        add_reflections(job, reflected, reflected_count);
        result = add_environments(job);
    }
    ty_sources_destroy(job->context, sources, count);
    ty_light_parts_destroy(job->context, reflected, reflected_count);
    return result;
}

ty_result ty_dom_take_sources(ty_dom_job* job) {
    ty_dom* light = job->light;
    float color[3] = {0};
    const ty_result result = make_sources(job);
    if (result != TY_OK) return result;
    if (job->source_count > 0)
        memcpy(color, job->sources[0].color, sizeof color);
    else
        emission_color(job->coarse, color);
    light->shared = !is_black(color) && light->planes == 1 && emission_shares(job->coarse, color) &&
                    ty_dom_walls_share(job) && ty_sources_share(job->sources, job->source_count, color);
    for (int c = 0; c < 3; ++c) light->color[c] = light->shared ? color[c] : 1;
    job->stats.planes = ty_dom_channels(light);
    return TY_OK;
}
