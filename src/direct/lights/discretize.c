/* Directions and points that stand for the lights of a scene. */
#include "direct/lights/discretize.h"

#include "base/check.h"
#include "scene/scene.h"

enum { SAMPLES_MAX = 65536, TRIANGLE_FACTOR = 4 };

typedef struct sampling {
    const ty_light_set* lights;
    ty_discretize_def def;
    ty_sobol sobol;
    ty_discrete_light_set* out;
} sampling;

ty_discretize_def ty_default_discretize_def(void) {
    return (ty_discretize_def){.environment = 64, .surface = 16};
}

static float brightness(const float rgb[3]) {
    return rgb[0] + rgb[1] + rgb[2];
}

static bool emits(const ty_light_view* light) {
    return light->kind == TY_KIND_TRIANGLE && brightness(light->color) > 0;
}

/* Power in watts, up to a factor that all triangles share. */
static double triangle_power(const ty_light_view* light) {
    return (double)(brightness(light->color) * light->area) * (light->two_sided != 0 ? 2 : 1);
}

static ty_discrete_light* append(sampling* s, ty_discrete_light_kind kind, int32_t light) {
    ty_discrete_light* sample = &s->out->items[s->out->count++];
    *sample = (ty_discrete_light){.kind = kind, .light = light, .mean_cosine = 1};
    return sample;
}

static void add_directional(sampling* s, int32_t index) {
    const ty_light_view* light = &s->lights->lights[index];
    ty_discrete_light* sample = append(s, TY_DISCRETE_DIRECTIONAL, index);
    sample->direction = light->direction;
    for (int c = 0; c < 3; ++c) sample->color[c] = light->color[c];
}

static void add_point(sampling* s, int32_t index) {
    const ty_light_view* light = &s->lights->lights[index];
    ty_discrete_light* sample = append(s, TY_DISCRETE_POINT, index);
    sample->position = light->position;
    sample->direction = light->direction;
    sample->profile = light->kind == TY_KIND_SPOT ? TY_PROFILE_SPOT : TY_PROFILE_ISOTROPIC;
    sample->is_point = true;
    for (int c = 0; c < 3; ++c) sample->color[c] = light->color[c];
}

/* Directions sampled in proportion to luminance, each with its share of the irradiance. */
static void add_environment(sampling* s, int32_t index) {
    const ty_environment_view* environment = &s->lights->lights[index].environment;
    for (int32_t i = 0; i < s->def.environment; ++i) {
        ty_sampler random = ty_sampler_begin(&s->sobol, s->def.seed, (uint64_t)index, (uint32_t)i);
        const float u = ty_sobol_next(&random), v = ty_sobol_next(&random);
        ty_vec wi;
        float radiance[3];
        const float pdf = ty_environment_sample(environment, u, v, &wi);
        if (!(pdf > 0)) continue;
        ty_environment_radiance(environment, wi, radiance);
        if (!(brightness(radiance) > 0)) continue;
        ty_discrete_light* sample = append(s, TY_DISCRETE_DIRECTIONAL, index);
        sample->direction = ty_scale(wi, -1);
        sample->mean_cosine = ty_maxf(0, 1 - 0.25f / (TY_PI * pdf * (float)s->def.environment));
        for (int c = 0; c < 3; ++c) sample->color[c] = radiance[c] / (pdf * (float)s->def.environment);
    }
}

/* A point of the disc before a spot's sphere, across its axis: it has the sphere's light along the axis, and the sphere
 * does not hide it. */
static void add_cone_point(const ty_light_view* light, float u, float v, ty_discrete_light* sample) {
    const float cosine = sqrtf(1 - u); /* the disc of radius sqrt(u), as a direction */
    const ty_vec on_disc = ty_direction_about(light->direction, cosine, v);
    const ty_vec off = ty_mad(on_disc, light->direction, 1.001f - cosine);
    sample->profile = TY_PROFILE_SPOT;
    sample->direction = light->direction;
    sample->position = ty_mad(light->position, off, light->radius);
    for (int c = 0; c < 3; ++c) sample->color[c] *= 0.25f; /* pi r^2 of 4 pi r^2 */
}

/* A point of an area light, sphere or triangle that stands for `area` of it, m^2. */
static void add_surface_point(sampling* s, int32_t index, uint32_t number, float area) {
    const ty_light_view* light = &s->lights->lights[index];
    const bool triangle = light->kind == TY_KIND_TRIANGLE;
    ty_sampler random = ty_sampler_begin(&s->sobol, s->def.seed, triangle ? UINT64_MAX : (uint64_t)index, number);
    const float u = ty_sobol_next(&random), v = ty_sobol_next(&random);
    ty_discrete_light* sample = append(s, TY_DISCRETE_POINT, index);
    sample->area = area;
    sample->profile = triangle && light->two_sided != 0 ? TY_PROFILE_TWO_SIDED : TY_PROFILE_COSINE;
    for (int c = 0; c < 3; ++c) sample->color[c] = light->color[c] * area;
    if (light->kind == TY_KIND_SPHERE) {
        if (light->cone != 0) {
            add_cone_point(light, u, v, sample);
            return;
        }
        sample->direction = ty_direction_about(ty_vec_make(0, 0, 1), 1 - 2 * u, v);
        sample->position = ty_mad(light->position, sample->direction, light->radius);
        return;
    }
    float b1, b2;
    sample->direction = light->direction;
    sample->position = ty_light_point(light, u, v, &b1, &b2);
    if (light->textured == NULL) return;
    float emitted[3];
    ty_surface_mean_emission(light->textured, light->primitive_id, b1, b2, emitted);
    for (int c = 0; c < 3; ++c) sample->color[c] = emitted[c] * area;
}

static void add_surface(sampling* s, int32_t index) {
    const ty_light_view* light = &s->lights->lights[index];
    const float area = light->kind == TY_KIND_SPHERE ? 4 * TY_PI * light->radius * light->radius : light->area;
    for (int32_t i = 0; i < s->def.surface; ++i) add_surface_point(s, index, (uint32_t)i, area / (float)s->def.surface);
}

/* Points on all emissive triangles, stratified along the cumulative sum of their powers. */
static void add_triangles(sampling* s) {
    double total = 0, passed = 0;
    const int32_t points = TRIANGLE_FACTOR * s->def.surface;
    int32_t next = 0;
    for (int32_t i = 0; i < s->lights->count; ++i)
        if (emits(&s->lights->lights[i])) total += triangle_power(&s->lights->lights[i]);
    for (int32_t i = 0; i < s->lights->count; ++i) {
        const ty_light_view* light = &s->lights->lights[i];
        if (!emits(light)) continue;
        const double power = triangle_power(light);
        passed += power;
        const float area = (float)((double)light->area * total / (power * points));
        for (; next < points && (next + 0.5) * total < passed * points; ++next)
            add_surface_point(s, i, (uint32_t)next, area);
    }
}

static int32_t sample_count(const ty_light_view* light, const ty_discretize_def* def) {
    if (light->kind == TY_KIND_ENVIRONMENT) return def->environment;
    if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_SPHERE) return def->surface;
    return light->kind == TY_KIND_TRIANGLE ? 0 : 1;
}

static void fill(sampling* s) {
    for (int32_t i = 0; i < s->lights->count; ++i) {
        const ty_light_view* light = &s->lights->lights[i];
        if (light->kind == TY_KIND_DIRECTIONAL) add_directional(s, i);
        if (light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT) add_point(s, i);
        if (light->kind == TY_KIND_ENVIRONMENT) add_environment(s, i);
        if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_SPHERE) add_surface(s, i);
    }
    add_triangles(s);
}

ty_result ty_discretize_lights(const ty_scene* scene, const ty_discretize_def* def, ty_discrete_light_set* out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    *out = (ty_discrete_light_set){.items = NULL};
    if (view == NULL) return TY_ERROR_ARGUMENT;
    ty_result result = ty_check_number(scene->context, "sources: environment", def->environment, 1, SAMPLES_MAX);
    if (result == TY_OK) result = ty_check_number(scene->context, "sources: surface", def->surface, 1, SAMPLES_MAX);
    if (result != TY_OK) return result;
    int64_t capacity = TRIANGLE_FACTOR * def->surface;
    for (int32_t i = 0; i < view->lights.count; ++i) capacity += sample_count(&view->lights.lights[i], def);
    result = ty_discrete_light_set_create(scene->context, "sources", capacity, out);
    if (result != TY_OK) return result;
    sampling s = {.lights = &view->lights, .def = *def, .out = out};
    ty_sobol_matrices(&s.sobol);
    fill(&s);
    return TY_OK;
}
