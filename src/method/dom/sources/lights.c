/* Samples of all lights of a scene. */
#include "base/context.h"
#include "direct/lights/discretize.h"
#include "direct/lights/environment_clusters.h"
#include "method/dom/solve/solve.h"
#include "method/dom/sources/sources.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Relative tolerance for colors that are multiples of each other. */
static const float color_tolerance = 1e-6f;

/* ---- colors ---- */

static bool is_black(const float color[3]) {
    return !(color[0] + color[1] + color[2] > 0);
}

/* The only color that all emission may be a multiple of; black without emission. */
static void emission_color(const ty_grid_medium* medium, float color[3]) {
    for (int c = 0; c < 3; ++c) color[c] = 0;
    for (size_t i = 0; i < medium->cells && is_black(color); ++i)
        for (int c = 0; c < 3; ++c) color[c] = medium->emission[c] != NULL ? medium->emission[c][i] : 0;
}

static bool emission_shares_color(const ty_grid_medium* medium, const float color[3]) {
    for (int c = 0; c < 3 && medium->emission[0] != NULL; ++c) {
        const int d = (c + 1) % 3;
        for (size_t i = 0; i < medium->cells; ++i) {
            const float a = medium->emission[c][i] * color[d], b = medium->emission[d][i] * color[c];
            if (fabsf(a - b) > color_tolerance * ty_maxf(a, b)) return false;
        }
    }
    return true;
}

/* ---- sources ---- */

static bool is_environment(const ty_light_set* lights, int32_t light) {
    return lights->lights[light].kind == TY_KIND_ENVIRONMENT;
}

static ty_result add_environments(ty_dom_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    const ty_environment_clusters_def def = {
        .count = job->def->environment_beams, .prefilter = 1, .seed = job->def->seed};
    ty_result result = TY_OK;
    for (int32_t i = 0; i < lights->count && result == TY_OK; ++i)
        if (is_environment(lights, i)) result = ty_environment_clusters_add(job->scene, &def, i, &job->sources);
    return result;
}

static void add(ty_dom_job* job, const ty_discrete_light* source) {
    if (!is_black(source->color)) job->sources.items[job->sources.count++] = *source;
}

static ty_result create_sources(ty_dom_job* job, int32_t others) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    int64_t capacity = others;
    for (int32_t i = 0; i < lights->count; ++i)
        if (is_environment(lights, i)) capacity += job->def->environment_beams;
    return ty_discrete_light_set_create(job->context, "dom", capacity, &job->sources);
}

static ty_result find_sources(ty_dom_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    const ty_discretize_def def = {.environment = 1, .surface = job->def->surface_points, .seed = job->def->seed};
    ty_discrete_light_set emitted = {.items = NULL};
    ty_result result = ty_discretize_lights(job->scene, &def, &emitted);
    if (result == TY_OK) result = create_sources(job, emitted.count);
    if (result == TY_OK) {
        for (int32_t i = 0; i < emitted.count; ++i)
            if (!is_environment(lights, emitted.items[i].light)) add(job, &emitted.items[i]);
        result = add_environments(job);
    }
    ty_discrete_light_set_destroy(job->context, &emitted);
    return result;
}

ty_result ty_dom_collect_lights(ty_dom_job* job) {
    ty_dom* light = job->light;
    float color[3] = {0};
    const ty_result result = find_sources(job);
    if (result != TY_OK) return result;
    if (job->sources.count > 0)
        memcpy(color, job->sources.items[0].color, sizeof color);
    else
        emission_color(job->coarse, color);
    light->shared = !is_black(color) && light->planes == 1 && emission_shares_color(job->coarse, color) &&
                    ty_dom_boundary_is_gray(job) &&
                    ty_discrete_lights_share_color(job->sources.items, job->sources.count, color);
    for (int c = 0; c < 3; ++c) light->color[c] = light->shared ? color[c] : 1;
    job->stats.planes = ty_dom_channels(light);
    return TY_OK;
}
