/* Conversion of a scene's lights to ordinates. */
#include "method/pop/ordinate/ordinate.h"

#include "direct/lights/environment_clusters.h"
#include "direct/lights/discretize.h"
#include "scene/scene.h"

typedef struct ordinate_list {
    const ty_scene* scene;
    const ty_pop_def* def;
    const ty_light_view* lights;
    ty_vec center;      /* of the media's box */
    float longest_edge; /* of the media's box, m */
    ty_discrete_light_set* out;
} ordinate_list;

static bool is_black(const float color[3]) {
    return !(color[0] + color[1] + color[2] > 0);
}

static bool can_use_fine_grid(const ty_light_view* light) {
    if (is_black(light->color)) return false;
    return light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT;
}

bool ty_pop_uses_fine_grid(const ty_scene* scene, const ty_pop_def* def, int32_t light) {
    const ty_light_set* set = &scene->view.lights;
    if (!def->fine_lights || def->mode != TY_POP_MODE_SPLIT || !can_use_fine_grid(&set->lights[light])) return false;
    int32_t before = 0;
    for (int32_t i = 0; i < light; ++i) before += can_use_fine_grid(&set->lights[i]);
    return before < TY_POP_FINE_LIGHTS_MAX;
}

static ty_discrete_light* append(ordinate_list* list, const ty_discrete_light* source) {
    ty_discrete_light* ordinate = &list->out->items[list->out->count++];
    *ordinate = *source;
    ordinate->shadowed = list->scene->view.mesh != NULL;
    return ordinate;
}

/* Point and spot lights: they have no size, so the lower bound of r is relative to the media's box. */
static void add_point(ordinate_list* list, const ty_discrete_light* source) {
    append(list, source)->min_distance = 1e-3f * list->longest_edge;
}

/* Mean cosine of a disc of some area seen from the box's center: (1 - Omega / 4 pi)^beta, as (1 - w_n / N)^beta of
 * environment directions (Elek 2014). */
static float cosine_of_area(const ordinate_list* list, ty_vec position, float area) {
    const ty_vec off = ty_sub(list->center, position);
    const float distance2 = ty_maxf(ty_dot(off, off), 0.25f * list->longest_edge * list->longest_edge);
    const float fraction = ty_minf(area / (4 * TY_PI * distance2), 1);
    return powf(1 - fraction, (float)list->def->prefilter);
}

/* One point of a surface. side: 1 for its front, -1 for its back. The lower bound of r in 1 / r^2 is the radius of a
 * disc of the point's area, below which that area is not a point. */
static void add_surface_point(ordinate_list* list, const ty_discrete_light* source, float side) {
    ty_discrete_light* ordinate = append(list, source);
    const float offset = 1e-4f * list->longest_edge;
    if (source->profile != TY_PROFILE_SPOT) ordinate->profile = TY_PROFILE_COSINE;
    ordinate->direction = ty_scale(source->direction, side);
    ordinate->position = ty_mad(source->position, ordinate->direction, offset);
    ordinate->min_distance = ty_maxf(sqrtf(source->area / TY_PI), 1e-3f * list->longest_edge);
    ordinate->mean_cosine = cosine_of_area(list, source->position, source->area);
}

static void add_source(ordinate_list* list, const ty_discrete_light* source) {
    const ty_light_view* light = &list->lights[source->light];
    if (is_black(source->color) || ty_pop_uses_fine_grid(list->scene, list->def, source->light)) return;
    if (light->kind == TY_KIND_DIRECTIONAL) append(list, source);
    if (light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT) add_point(list, source);
    if (source->area > 0) add_surface_point(list, source, 1);
    if (light->kind == TY_KIND_TRIANGLE && light->two_sided != 0) add_surface_point(list, source, -1);
}

static ty_result add_environments(ordinate_list* list, const float* importance) {
    const ty_pop_def* pop = list->def;
    const ty_environment_clusters_def def = {.count = pop->ordinates,
                                             .prefilter = pop->prefilter,
                                             .by_solid_angle = pop->mode == TY_POP_MODE_PUBLISHED,
                                             .seed = pop->seed,
                                             .importance = importance,
                                             .width = TY_POP_IMPORTANCE_WIDTH,
                                             .height = TY_POP_IMPORTANCE_HEIGHT};
    for (int32_t i = 0; i < list->scene->view.lights.count; ++i) {
        if (list->lights[i].kind != TY_KIND_ENVIRONMENT) continue;
        const ty_result result = ty_environment_clusters_add(list->scene, &def, i, list->out);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

/* Upper bound of the number of ordinates from sources and environments. */
static int64_t capacity_of(const ordinate_list* list, int32_t sources) {
    int64_t capacity = 2 * (int64_t)sources;
    for (int32_t i = 0; i < list->scene->view.lights.count; ++i)
        if (list->lights[i].kind == TY_KIND_ENVIRONMENT) capacity += list->def->ordinates;
    return capacity;
}

static void set_box(ordinate_list* list, const ty_grid_box* box) {
    double center[3], longest_edge = 0;
    for (int a = 0; a < 3; ++a) {
        center[a] = 0.5 * (box->lower[a] + box->upper[a]);
        longest_edge = fmax(longest_edge, box->upper[a] - box->lower[a]);
    }
    list->center = ty_vec_make((float)center[0], (float)center[1], (float)center[2]);
    list->longest_edge = (float)longest_edge;
}

ty_result ty_pop_ordinates_create(const ty_scene* scene, const ty_pop_def* def, const ty_grid_box* box,
                                  const float* importance, ty_discrete_light_set* out) {
    const ty_discretize_def discretize = {.environment = 1, .surface = def->surface_points, .seed = def->seed};
    ty_discrete_light_set sources;
    *out = (ty_discrete_light_set){.items = NULL};
    ty_result result = ty_discretize_lights(scene, &discretize, &sources);
    if (result != TY_OK) return result;
    ordinate_list list = {.scene = scene, .def = def, .lights = scene->view.lights.lights, .out = out};
    set_box(&list, box);
    result = ty_discrete_light_set_create(scene->context, "ordinates", capacity_of(&list, sources.count), out);
    for (int32_t i = 0; i < sources.count && result == TY_OK; ++i) add_source(&list, &sources.items[i]);
    ty_discrete_light_set_destroy(scene->context, &sources);
    return result == TY_OK ? add_environments(&list, importance) : result;
}
