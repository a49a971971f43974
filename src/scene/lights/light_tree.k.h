/* Light selection by a tree of light clusters (Conty Estevez and Kulla 2018): each step from the root selects one of
 * two children in proportion to an importance bound. A light that can contribute has a probability above 0; where
 * bounds overestimate, a descent can end without a light. */
#ifndef TY_SCENE_LIGHTS_LIGHT_TREE_K_H
#define TY_SCENE_LIGHTS_LIGHT_TREE_K_H

#include "scene/lights/light.k.h"

/* Tolerance of cosines, and of lengths over the distance: keeps rounding from hiding a light. */
#define TY_LIGHT_TOLERANCE 2e-3f
/* Trail of a light that is not in the tree. */
#define TY_LIGHT_NO_TRAIL 0xffffffffffffffffu

/* A cluster of lights, one cache line. Its lights lie in the box center +- half and emit within theta_o + theta_e of
 * the axis: theta_o bounds the axes of the lights, theta_e the emission about each of them. */
typedef struct ty_light_node {
    ty_vec center, half;
    float radius2; /* half squared: squared radius of the box's bounding sphere */
    ty_vec axis;
    float cos_o, sin_o, cos_e;
    float power, local_power; /* of all its lights and of its local lights, as fractions of the tree's power */
    int32_t next;             /* second child (the first follows its parent); in a leaf: ~ index of the light */
} ty_light_node;

/* The reflection of a glossy surface, for the importance of lights: a lobe of GGX about the mirror direction. */
typedef struct ty_light_lobe {
    ty_vec axis;  /* unit, towards the light */
    float alpha2; /* alpha^2 of the microfacets */
    float weight; /* part of the reflected light, 0..1, that is in the lobe; the rest is diffuse */
} ty_light_lobe;

/* Cosine of max(a - b, 0); *sine is its sine. */
TY_FN float ty_light_cos_less(float cos_a, float sin_a, float cos_b, float sin_b, float* sine) {
    if (cos_a >= cos_b) {
        *sine = 0.0f;
        return 1.0f;
    }
    *sine = ty_maxf(0.0f, sin_a * cos_b - cos_a * sin_b);
    return cos_a * cos_b + sin_a * sin_b;
}

TY_FN float ty_light_sin_of(float cosine) {
    return sqrtf(ty_maxf(0.0f, 1.0f - cosine * cosine));
}

/* Half extent of a box along an axis, from its half edges. */
TY_FN float ty_light_extent(ty_vec half, ty_vec axis) {
    return fabsf(axis.x) * half.x + fabsf(axis.y) * half.y + fabsf(axis.z) * half.z;
}

/* The factor that takes the place of the cosine of incidence where a surface is glossy: its BSDF times cosine, times
 * pi, with D(h) / 4 for the lobe about a unit direction. The lobe is widened by the angular radius of the cluster,
 * given by its sine. */
TY_FN float ty_light_lobe_factor(const ty_light_lobe* lobe, float cosine, ty_vec direction, float sin_u) {
    const float a2 = lobe->alpha2 + 0.25f * sin_u * sin_u;
    const float cos2_half = ty_clampf(0.5f + 0.5f * ty_dot(lobe->axis, direction), 0.0f, 1.0f);
    const float stretched = 1.0f - cos2_half + a2 * cos2_half;
    return (1.0f - lobe->weight) * cosine + lobe->weight * 0.25f * a2 / ty_maxf(stretched * stretched, 1e-12f);
}

/* Importance of a cluster for a point: power over squared distance, times the cosines of emission and incidence. Near
 * and inside a cluster the distance is meaningless, so it has a lower bound. The cosines are interpolated between those
 * of center and axis, which are right on average, and their maxima, which miss no light; zero maxima mean zero
 * importance. The interpolation weights were chosen by measured noise. normal is 0 for points in a medium. lobe:
 * of a glossy surface; NULL: the surface is diffuse. */
TY_FN float ty_light_node_importance(TY_GLOBAL const ty_light_node* node, ty_vec from, ty_vec normal,
                                     const ty_light_lobe* lobe) {
    const ty_vec to = ty_sub(node->center, from);
    const float d2 = ty_dot(to, to), d = sqrtf(d2);
    const float tolerance = TY_LIGHT_TOLERANCE * (d + sqrtf(node->radius2));
    const float cos_incident = ty_dot(normal, to), cos_emitted = -ty_dot(node->axis, to);
    if (cos_incident + ty_light_extent(node->half, normal) < -tolerance) return 0.0f;
    /* Coplanar lights, within the tolerance: no emission behind the plane. */
    if (node->cos_o > 0.999999f && node->cos_e >= 0.0f &&
        cos_emitted + ty_light_extent(node->half, node->axis) < -tolerance)
        return 0.0f;
    float importance = node->power / ty_maxf(ty_maxf(d2, 0.25f * node->radius2), 1e-18f);
    if (d2 <= node->radius2)
        return lobe == NULL ? importance : importance * ty_light_lobe_factor(lobe, 1.0f, lobe->axis, 1.0f);
    float sine;
    const float sin_u = sqrtf(node->radius2) / d, cos_u = ty_light_sin_of(sin_u);
    if (ty_dot(normal, normal) > 0.0f) {
        const float mu = ty_clampf(cos_incident / d, -1.0f, 1.0f);
        const float max_cosine = ty_light_cos_less(mu, ty_light_sin_of(mu), cos_u, sin_u, &sine);
        const float cosine = ty_maxf(ty_lerpf(ty_maxf(0.0f, mu), max_cosine, 0.7f), TY_LIGHT_TOLERANCE);
        importance *= lobe == NULL ? cosine : ty_light_lobe_factor(lobe, cosine, ty_scale(to, 1.0f / d), sin_u);
    }
    if (node->cos_o <= -1.0f) return importance;
    float mu = ty_clampf(cos_emitted / d, -1.0f, 1.0f);
    mu = ty_light_cos_less(mu, ty_light_sin_of(mu), cos_u, sin_u, &sine);
    mu = ty_light_cos_less(mu, sine, node->cos_o, node->sin_o, &sine);
    if (mu < node->cos_e - TY_LIGHT_TOLERANCE) return 0.0f;
    const float weight = node->radius2 > 0.0f ? 0.3f : 1.0f; /* point lights: exact */
    return importance * ty_maxf(ty_lerpf(ty_maxf(0.0f, cos_emitted / d), mu, weight), TY_LIGHT_TOLERANCE);
}

/* Probability of the first of two children; -1 if neither is important. An important child is never excluded. */
TY_FN float ty_light_first_probability(float first, float second) {
    if (!(first > 0.0f)) return second > 0.0f ? 0.0f : -1.0f;
    if (!(second > 0.0f)) return 1.0f;
    return ty_clampf(first / (first + second), 1e-6f, 1.0f - 1e-6f);
}

TY_FN float ty_light_tree_first_probability(TY_GLOBAL const ty_light_node* nodes, int32_t node, ty_vec from,
                                            ty_vec normal, const ty_light_lobe* lobe) {
    return ty_light_first_probability(ty_light_node_importance(&nodes[node + 1], from, normal, lobe),
                                      ty_light_node_importance(&nodes[nodes[node].next], from, normal, lobe));
}

/* One step down: the child selected by *u, with *u rescaled to [0, 1). */
TY_FN int32_t ty_light_tree_step(TY_GLOBAL const ty_light_node* nodes, int32_t node, float probability_first, float* u,
                                 float* probability) {
    const bool first = *u < probability_first;
    const float selected = first ? probability_first : 1.0f - probability_first;
    *u = ty_clampf((first ? *u : *u - probability_first) / selected, 0.0f, 0x1.fffffep-1f);
    *probability *= selected;
    return first ? node + 1 : nodes[node].next;
}

/* Selects a light for point `from` on a surface with unit normal on the receiving side, or normal 0 in a medium. Each
 * step consumes random bits of *u. nodes NULL: no lights. Returns -1, with probability 0, if the descent finds no
 * important child. lobe: as in ty_light_node_importance. */
TY_FN int32_t ty_light_tree_sample(TY_GLOBAL const ty_light_node* nodes, ty_vec from, ty_vec normal,
                                   const ty_light_lobe* lobe, float* u, float* probability) {
    int32_t node = 0;
    *probability = 0.0f;
    if (nodes == NULL) return -1;
    float product = 1.0f;
    while (nodes[node].next >= 0) {
        const float probability_first = ty_light_tree_first_probability(nodes, node, from, normal, lobe);
        if (probability_first < 0.0f) return -1;
        node = ty_light_tree_step(nodes, node, probability_first, u, &product);
    }
    *probability = product;
    return ~nodes[node].next;
}

/* Probability with which ty_light_tree_sample selects a light, by the same operations; 0 for lights outside the tree.
 * trails: of the ty_light_tree. */
TY_FN float ty_light_tree_probability(TY_GLOBAL const ty_light_node* nodes, TY_GLOBAL const uint64_t* trails,
                                      int32_t light, ty_vec from, ty_vec normal, const ty_light_lobe* lobe) {
    uint64_t trail = trails[light];
    if (trail == TY_LIGHT_NO_TRAIL) return 0.0f;
    float product = 1.0f;
    for (int32_t node = 0; nodes[node].next >= 0; trail >>= 1) {
        const float probability_first = ty_light_tree_first_probability(nodes, node, from, normal, lobe);
        if (probability_first < 0.0f) return 0.0f;
        product *= (trail & 1u) == 0 ? probability_first : 1.0f - probability_first;
        node = (trail & 1u) == 0 ? node + 1 : nodes[node].next;
    }
    return product;
}

/* Importance of a cluster's local lights for [enter, leave] of a ray: the integral of power over squared distance from
 * its center, i.e. the angle subtended by the segment over its distance to the ray. */
TY_FN float ty_light_node_ray_importance(TY_GLOBAL const ty_light_node* node, ty_vec origin, ty_vec direction,
                                         float enter, float leave) {
    const ty_vec to = ty_sub(node->center, origin);
    const float closest = ty_dot(to, direction);
    const ty_vec perpendicular = ty_mad(to, direction, -closest);
    const float floor2 = 0.1f * node->radius2 + 1e-10f * ty_dot(to, to) + 1e-18f;
    const float off2 = ty_maxf(ty_dot(perpendicular, perpendicular), floor2), off = sqrtf(off2);
    const float angle = ty_atan2_over_2pi(off * (leave - enter), off2 + (enter - closest) * (leave - closest));
    return node->local_power * angle / off;
}

/* Probability of the first child of a node for [enter, leave] of a ray; -1 if neither has local lights. */
TY_FN float ty_light_tree_ray_first_probability(TY_GLOBAL const ty_light_node* nodes, int32_t node, ty_vec origin,
                                                ty_vec direction, float enter, float leave) {
    return ty_light_first_probability(
        ty_light_node_ray_importance(&nodes[node + 1], origin, direction, enter, leave),
        ty_light_node_ray_importance(&nodes[nodes[node].next], origin, direction, enter, leave));
}

/* Selects a local light for single scattering along [enter, leave] of a ray. Returns -1, with probability 0, if there
 * is no local light or the segment is empty. */
TY_FN int32_t ty_light_tree_sample_ray(TY_GLOBAL const ty_light_node* nodes, ty_vec origin, ty_vec direction,
                                       float enter, float leave, float* u, float* probability) {
    const float far = ty_minf(leave, 1e15f);
    int32_t node = 0;
    *probability = 0.0f;
    if (nodes == NULL || !(nodes[0].local_power > 0.0f) || !(far > enter)) return -1;
    float product = 1.0f;
    while (nodes[node].next >= 0) {
        const float probability_first = ty_light_tree_ray_first_probability(nodes, node, origin, direction, enter, far);
        if (probability_first < 0.0f) return -1;
        node = ty_light_tree_step(nodes, node, probability_first, u, &product);
    }
    *probability = product;
    return ~nodes[node].next;
}

/* Probability with which ty_light_tree_sample_ray selects a local light, by the same operations. */
TY_FN float ty_light_tree_ray_probability(TY_GLOBAL const ty_light_node* nodes, TY_GLOBAL const uint64_t* trails,
                                          int32_t light, ty_vec origin, ty_vec direction, float enter, float leave) {
    const float far = ty_minf(leave, 1e15f);
    uint64_t trail = trails[light];
    if (trail == TY_LIGHT_NO_TRAIL || !(far > enter)) return 0.0f;
    float product = 1.0f;
    for (int32_t node = 0; nodes[node].next >= 0; trail >>= 1) {
        const float probability_first = ty_light_tree_ray_first_probability(nodes, node, origin, direction, enter, far);
        if (probability_first < 0.0f) return 0.0f;
        product *= (trail & 1u) == 0 ? probability_first : 1.0f - probability_first;
        node = (trail & 1u) == 0 ? node + 1 : nodes[node].next;
    }
    return product;
}

#endif
