/* Lights of all kinds, and trees of them, for tests. */
#ifndef TY_TESTS_LIGHT_MAKER_H
#define TY_TESTS_LIGHT_MAKER_H

#include "checks.h"
#include "scene/lights/light_tree.h"

enum { LIGHTS_MAX = 100000 };

static ty_light_view views[LIGHTS_MAX];
static ty_light_bounds bounds[LIGHTS_MAX];

static inline ty_vec random_point(uint64_t* state, double half) {
    const double x = uniform_in(state, -half, half), y = uniform_in(state, -half, half);
    return ty_vec_make((float)x, (float)y, (float)uniform_in(state, -half, half));
}

static inline ty_light_view lamp_at(ty_vec position, float intensity) {
    ty_light_view view = {.kind = TY_KIND_POINT, .position = position};
    for (int c = 0; c < 3; ++c) view.color[c] = intensity;
    return view;
}

static inline ty_light_view random_lamp(uint64_t* state, double half) {
    const ty_vec position = random_point(state, half);
    return lamp_at(position, (float)uniform_in(state, 0.5, 2));
}

static inline ty_vec random_edge(uint64_t* state) {
    const ty_vec direction = random_unit(state);
    return ty_scale(direction, (float)pow(10, uniform_in(state, -2, 0.3)));
}

/* A light of a kind somewhere in a cube, of any size and brightness. */
static inline ty_light_view random_light(uint64_t* state, int32_t kind, double half) {
    const ty_vec position = random_point(state, half);
    ty_light_view view = lamp_at(position, (float)pow(10, uniform_in(state, -2, 2)));
    view.kind = kind;
    view.direction = random_unit(state);
    view.u = random_edge(state);
    view.v = random_edge(state);
    view.radius = (float)pow(10, uniform_in(state, -2, 0));
    const double outer = uniform_in(state, 0.01, 1.57);
    view.cos_outer = (float)cos(outer);
    view.cos_inner = (float)cos(outer * uniform(state));
    if (kind != TY_KIND_AREA && kind != TY_KIND_TRIANGLE) return view;
    const ty_vec cross = ty_cross(view.u, view.v);
    const float length = sqrtf(ty_dot(cross, cross));
    view.direction = ty_scale(cross, 1 / length);
    view.area = kind == TY_KIND_AREA ? length : 0.5f * length;
    view.two_sided = kind == TY_KIND_TRIANGLE && uniform(state) < 0.3;
    return view;
}

/* Light from a light's point (u, v) to a point: triangles as half a parallelogram. */
static inline bool light_sent(const ty_light_view* light, ty_vec from, float u, float v, ty_light_sample* sample) {
    if (light->kind != TY_KIND_TRIANGLE) return ty_light_sample_from(light, from, u, v, sample);
    ty_light_view half = *light;
    half.kind = TY_KIND_AREA;
    if (light->two_sided && ty_dot(ty_sub(from, light->position), light->direction) < 0)
        half.direction = ty_scale(light->direction, -1);
    return ty_light_sample_from(&half, from, u + v > 1 ? 1 - u : u, u + v > 1 ? 1 - v : v, sample);
}

static inline ty_light_tree* tree_of(ty_context* context, size_t count) {
    ty_light_tree* tree = NULL;
    for (size_t i = 0; i < count; ++i) ty_light_get_bounds(&views[i], &bounds[i]);
    assert_int_equal(ty_light_tree_create(context, bounds, count, &tree), TY_OK);
    return tree;
}

/* Lights of the kinds that have a place; `kinds` of them, from points on. */
static inline ty_light_tree* random_tree(ty_context* context, uint64_t* state, size_t count, int32_t kinds,
                                         double half) {
    static const int32_t kind[5] = {TY_KIND_POINT, TY_KIND_SPHERE, TY_KIND_SPOT, TY_KIND_AREA, TY_KIND_TRIANGLE};
    for (size_t i = 0; i < count; ++i) views[i] = random_light(state, kind[i % (size_t)kinds], half);
    return tree_of(context, count);
}

#endif
