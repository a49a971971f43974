/* A scene's lights as ordinates. */
#include "method/pop/ordinate.h"

#include "base/context.h"
#include "direct/lights/environment_clusters.h"
#include "direct/lights/discretize.h"
#include "scene/scene.h"

typedef struct ordinate_list {
    const ty_scene* scene;
    const ty_pop_def* def;
    const ty_light_view* lights;
    ty_vec middle; /* of the media */
    float longest; /* side of their box, m */
    ty_light_part* items;
    int32_t count;
} ordinate_list;

static bool is_black(const float color[3]) {
    return !(color[0] + color[1] + color[2] > 0);
}

static bool may_be_sharp(const ty_light_view* light) {
    if (is_black(light->color)) return false;
    return light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT;
}

bool ty_pop_is_sharp(const ty_scene* scene, const ty_pop_def* def, int32_t light) {
    const ty_light_set* set = &scene->view.lights;
    if (!def->sharp || def->mode != TY_POP_MODE_SPLIT || !may_be_sharp(&set->lights[light])) return false;
    int32_t before = 0;
    for (int32_t i = 0; i < light; ++i) before += may_be_sharp(&set->lights[i]);
    return before < TY_POP_SHARP_MAX;
}

static ty_light_part* append(ordinate_list* list, const ty_source* source) {
    ty_light_part* ordinate = &list->items[list->count++];
    *ordinate = (ty_light_part){.kind = source->kind == TY_SOURCE_BEAM ? TY_LIGHT_PART_PARALLEL : TY_LIGHT_PART_RADIAL,
                                .direction = source->direction,
                                .position = source->position,
                                .cosine = 1,
                                .light = source->light,
                                .shadowed = list->scene->view.mesh != NULL};
    for (int c = 0; c < 3; ++c) ordinate->color[c] = source->color[c];
    return ordinate;
}

/* Point and spot lights: there is no distance below which they are not points, so media are asked for one. */
static void add_point(ordinate_list* list, const ty_source* source) {
    ty_light_part* ordinate = append(list, source);
    ordinate->profile = list->lights[source->light].kind == TY_KIND_SPOT ? TY_LIGHT_PART_SPOT : TY_LIGHT_PART_EVEN;
    ordinate->least = 1e-3f * list->longest;
}

/* Mean cosine of light from a disc of some area about the way to the middle of the media: its solid angle over 4 pi is
 * what w / N is for directions. */
static float cosine_of_area(const ordinate_list* list, ty_vec position, float area) {
    const ty_vec off = ty_sub(list->middle, position);
    const float distance2 = ty_maxf(ty_dot(off, off), 0.25f * list->longest * list->longest);
    const float share = ty_minf(area / (4 * TY_PI * distance2), 1);
    return powf(1 - share, (float)list->def->prefilter);
}

/* A point of a surface; side: 1 in front of it, -1 behind. Its 1 / r^2 is held where the part that it stands for is no
 * point any more: about the radius of a disc of the same area. */
static void add_surface_point(ordinate_list* list, const ty_source* source, float side) {
    ty_light_part* ordinate = append(list, source);
    const float lift = 1e-4f * list->longest;
    ordinate->profile = TY_LIGHT_PART_COSINE;
    ordinate->direction = ty_scale(source->direction, side);
    ordinate->position = ty_mad(source->position, ordinate->direction, lift);
    ordinate->least = ty_maxf(sqrtf(source->area / TY_PI), 1e-3f * list->longest);
    ordinate->cosine = cosine_of_area(list, source->position, source->area);
}

static void add_source(ordinate_list* list, const ty_source* source) {
    const ty_light_view* light = &list->lights[source->light];
    if (is_black(source->color) || ty_pop_is_sharp(list->scene, list->def, source->light)) return;
    if (light->kind == TY_KIND_DIRECTIONAL) append(list, source);
    if (light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT) add_point(list, source);
    if (source->area > 0) add_surface_point(list, source, 1);
    if (light->kind == TY_KIND_TRIANGLE && light->two_sided != 0) add_surface_point(list, source, -1);
}

static ty_result add_environments(ordinate_list* list, const float* importance) {
    const ty_pop_def* pop = list->def;
    const ty_environment_parts_def def = {.parts = pop->ordinates,
                                          .prefilter = pop->prefilter,
                                          .by_share = pop->mode == TY_POP_MODE_PUBLISHED,
                                          .seed = pop->seed,
                                          .importance = importance,
                                          .width = TY_POP_IMPORTANCE_WIDTH,
                                          .height = TY_POP_IMPORTANCE_HEIGHT};
    for (int32_t i = 0; i < list->scene->view.lights.count; ++i) {
        if (list->lights[i].kind != TY_KIND_ENVIRONMENT) continue;
        int32_t count = 0;
        const ty_result result = ty_environment_parts(list->scene, &def, i, list->items + list->count, &count);
        if (result != TY_OK) return result;
        list->count += count;
    }
    return TY_OK;
}

/* Ordinates that sources and environments become at most. */
static int64_t capacity_of(const ordinate_list* list, int32_t sources) {
    int64_t capacity = 2 * (int64_t)sources;
    for (int32_t i = 0; i < list->scene->view.lights.count; ++i)
        if (list->lights[i].kind == TY_KIND_ENVIRONMENT) capacity += list->def->ordinates;
    return capacity;
}

static void measure_box(ordinate_list* list, const ty_grid_box* box) {
    double middle[3], longest = 0;
    for (int a = 0; a < 3; ++a) {
        middle[a] = 0.5 * (box->lower[a] + box->upper[a]);
        longest = fmax(longest, box->upper[a] - box->lower[a]);
    }
    list->middle = ty_vec_make((float)middle[0], (float)middle[1], (float)middle[2]);
    list->longest = (float)longest;
}

ty_result ty_pop_ordinates_create(const ty_scene* scene, const ty_pop_def* def, const ty_grid_box* box,
                                  const float* importance, ty_light_part** out, int32_t* count) {
    const ty_source_def source_def = {.environment = 1, .surface = def->surface_points, .seed = def->seed};
    ty_source* sources = NULL;
    int32_t source_count = 0;
    ty_result result = ty_sources_create(scene, &source_def, &sources, &source_count);
    if (result != TY_OK) return result;
    ordinate_list list = {.scene = scene, .def = def, .lights = scene->view.lights.lights};
    const int64_t capacity = capacity_of(&list, source_count);
    measure_box(&list, box);
    if (capacity > INT32_MAX)
        result = ty_fail(scene->context, TY_ERROR_ARGUMENT, "ordinates: %lld of them", (long long)capacity);
    if (result == TY_OK) {
        list.items = ty_alloc_array(scene->context, (size_t)capacity, sizeof *list.items, false);
        if (list.items == NULL) result = TY_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < source_count && result == TY_OK; ++i) add_source(&list, &sources[i]);
    ty_sources_destroy(scene->context, sources, source_count);
    if (list.items == NULL) return result;
    if (result == TY_OK) result = add_environments(&list, importance);
    if (result == TY_OK) return ty_light_parts_trim(scene->context, list.items, capacity, list.count, out, count);
    ty_free_array(scene->context, list.items, (size_t)capacity, sizeof *list.items);
    return result;
}
