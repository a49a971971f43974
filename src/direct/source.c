/* Beams and lamps of a scene. */
#include "direct/source.h"

#include "base/context.h"
#include "scene/check.h"
#include "scene/scene.h"

enum { PARTS_MAX = 65536, TRIANGLE_FACTOR = 4 };

typedef struct source_list {
    ty_context* context;
    const ty_light_set* lights;
    ty_source_def def;
    ty_sobol sobol;
    ty_source* items;
    int32_t count, capacity;
} source_list;

ty_source_def ty_default_source_def(void) {
    return (ty_source_def){.environment = 64, .surface = 16};
}

static float brightness(const float rgb[3]) {
    return rgb[0] + rgb[1] + rgb[2];
}

static bool glows(const ty_light_view* light) {
    return light->kind == TY_KIND_TRIANGLE && brightness(light->color) > 0;
}

/* Watts, up to a factor that all triangles share. */
static double triangle_power(const ty_light_view* light) {
    return (double)(brightness(light->color) * light->area) * (light->two_sided != 0 ? 2 : 1);
}

static ty_source* append(source_list* list, ty_source_kind kind, int32_t light) {
    ty_source* source = &list->items[list->count++];
    *source = (ty_source){.kind = kind, .light = light, .cosine = 1};
    return source;
}

static void add_beam(source_list* list, int32_t index) {
    const ty_light_view* light = &list->lights->lights[index];
    ty_source* source = append(list, TY_SOURCE_BEAM, index);
    source->direction = light->direction;
    for (int c = 0; c < 3; ++c) source->color[c] = light->color[c];
}

static void add_point(source_list* list, int32_t index) {
    const ty_light_view* light = &list->lights->lights[index];
    ty_source* source = append(list, TY_SOURCE_LAMP, index);
    source->position = light->position;
    source->direction = light->direction;
    source->alone = 1;
    for (int c = 0; c < 3; ++c) source->color[c] = light->color[c];
}

/* Directions in proportion to luminance, each with its share of the irradiance. */
static void add_environment(source_list* list, int32_t index) {
    const ty_environment_view* environment = &list->lights->lights[index].environment;
    for (int32_t i = 0; i < list->def.environment; ++i) {
        ty_sampler random = ty_sampler_begin(&list->sobol, list->def.seed, (uint64_t)index, (uint32_t)i);
        const float u = ty_sobol_next(&random), v = ty_sobol_next(&random);
        ty_vec look;
        float radiance[3];
        const float pdf = ty_environment_sample(environment, u, v, &look);
        if (!(pdf > 0)) continue;
        ty_environment_radiance(environment, look, radiance);
        if (!(brightness(radiance) > 0)) continue;
        ty_source* source = append(list, TY_SOURCE_BEAM, index);
        source->direction = ty_scale(look, -1);
        source->cosine = ty_maxf(0, 1 - 0.25f / (TY_PI * pdf * (float)list->def.environment));
        for (int c = 0; c < 3; ++c) source->color[c] = radiance[c] / (pdf * (float)list->def.environment);
    }
}

/* A point of an area light, sphere or triangle that stands for `area` of it, m^2. */
static void add_surface_point(source_list* list, int32_t index, uint32_t sample, float area) {
    const ty_light_view* light = &list->lights->lights[index];
    const uint64_t item = light->kind == TY_KIND_TRIANGLE ? UINT64_MAX : (uint64_t)index;
    ty_sampler random = ty_sampler_begin(&list->sobol, list->def.seed, item, sample);
    const float u = ty_sobol_next(&random), v = ty_sobol_next(&random);
    ty_source* source = append(list, TY_SOURCE_LAMP, index);
    source->area = area;
    for (int c = 0; c < 3; ++c) source->color[c] = light->color[c] * area;
    if (light->kind == TY_KIND_SPHERE) {
        source->direction = ty_direction_about(ty_vec_make(0, 0, 1), 1 - 2 * u, v);
        source->position = ty_mad(light->position, source->direction, light->radius);
        return;
    }
    float b1, b2;
    source->direction = light->direction;
    source->position = ty_light_point(light, u, v, &b1, &b2);
    if (light->textured == NULL) return;
    float sent[3];
    ty_surface_mean_emission(light->textured, light->primitive_id, b1, b2, sent);
    for (int c = 0; c < 3; ++c) source->color[c] = sent[c] * area;
}

static void add_surface(source_list* list, int32_t index) {
    const ty_light_view* light = &list->lights->lights[index];
    const float area = light->kind == TY_KIND_SPHERE ? 4 * TY_PI * light->radius * light->radius : light->area;
    for (int32_t i = 0; i < list->def.surface; ++i)
        add_surface_point(list, index, (uint32_t)i, area / (float)list->def.surface);
}

/* Points on all glowing triangles, evenly along the sum of their powers. */
static void add_triangles(source_list* list) {
    double total = 0, passed = 0;
    const int32_t points = TRIANGLE_FACTOR * list->def.surface;
    int32_t next = 0;
    for (int32_t i = 0; i < list->lights->count; ++i)
        if (glows(&list->lights->lights[i])) total += triangle_power(&list->lights->lights[i]);
    for (int32_t i = 0; i < list->lights->count; ++i) {
        const ty_light_view* light = &list->lights->lights[i];
        if (!glows(light)) continue;
        const double power = triangle_power(light);
        passed += power;
        const float area = (float)((double)light->area * total / (power * points));
        for (; next < points && (next + 0.5) * total < passed * points; ++next)
            add_surface_point(list, i, (uint32_t)next, area);
    }
}

static int32_t parts_of(const ty_light_view* light, const ty_source_def* def) {
    if (light->kind == TY_KIND_ENVIRONMENT) return def->environment;
    if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_SPHERE) return def->surface;
    return light->kind == TY_KIND_TRIANGLE ? 0 : 1;
}

static void fill(source_list* list) {
    for (int32_t i = 0; i < list->lights->count; ++i) {
        const ty_light_view* light = &list->lights->lights[i];
        if (light->kind == TY_KIND_DIRECTIONAL) add_beam(list, i);
        if (light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT) add_point(list, i);
        if (light->kind == TY_KIND_ENVIRONMENT) add_environment(list, i);
        if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_SPHERE) add_surface(list, i);
    }
    add_triangles(list);
}

ty_result ty_sources_create(const ty_scene* scene, const ty_source_def* def, ty_source** out, int32_t* count) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    ty_result result = ty_check_number(scene->context, "sources: environment", def->environment, 1, PARTS_MAX);
    if (result == TY_OK) result = ty_check_number(scene->context, "sources: surface", def->surface, 1, PARTS_MAX);
    if (result != TY_OK) return result;
    source_list list = {.context = scene->context, .lights = &view->lights, .def = *def};
    int64_t capacity = TRIANGLE_FACTOR * def->surface;
    for (int32_t i = 0; i < view->lights.count; ++i) capacity += parts_of(&view->lights.lights[i], def);
    if (capacity > INT32_MAX)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "sources: %lld beams and lamps", (long long)capacity);
    list.items = ty_alloc_array(scene->context, (size_t)capacity, sizeof *list.items, false);
    if (list.items == NULL) return TY_ERROR_MEMORY;
    ty_sobol_matrices(&list.sobol);
    fill(&list);
    ty_source* exact = ty_alloc_array(scene->context, (size_t)list.count, sizeof *exact, false);
    if (exact != NULL) memcpy(exact, list.items, (size_t)list.count * sizeof *exact);
    ty_free_array(scene->context, list.items, (size_t)capacity, sizeof *list.items);
    if (exact == NULL) return TY_ERROR_MEMORY;
    *out = exact;
    *count = list.count;
    return TY_OK;
}

void ty_sources_destroy(ty_context* context, ty_source* sources, int32_t count) {
    ty_free_array(context, sources, (size_t)count, sizeof *sources);
}
