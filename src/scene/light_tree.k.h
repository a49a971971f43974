/* Choosing one of many lights by a tree of light clusters (Conty Estevez and Kulla 2018): from the root down, each step
 * takes one of two children in proportion to a bound on what its lights can send. A light that can send anything has a
 * probability above 0; where bounds promised more than there is, a descent ends without a light. */
#ifndef TY_SCENE_LIGHT_TREE_K_H
#define TY_SCENE_LIGHT_TREE_K_H

#include "scene/light.k.h"

/* What a cosine, or a length over the distance, may be wrong by: keeps rounding from hiding a light. */
#define TY_LIGHT_SLACK 2e-3f
/* The trail of a light that is not in the tree. */
#define TY_LIGHT_NO_TRAIL 0xffffffffffffffffu

/* A cluster of lights, one cache line. Its lights lie in the box center +- half, and send light only at up to
 * theta_o + theta_e from the axis: theta_o bounds the lights' own axes, theta_e the light about each of them. */
typedef struct ty_light_node {
    ty_vec center, half;
    float radius2; /* half squared: of the box's sphere */
    ty_vec axis;
    float cos_o, sin_o, cos_e;
    float power, lamp_power; /* of its lights and of the lamps among them, in parts of the whole tree's power */
    int32_t next;            /* the second child (the first follows its parent); in a leaf: ~ the light's number */
} ty_light_node;

/* The cosine of an angle a made smaller by b, but not below 0; *sine is its sine. */
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

/* How far a box with some half edges reaches along an axis from its centre. */
TY_FN float ty_light_extent(ty_vec half, ty_vec axis) {
    return fabsf(axis.x) * half.x + fabsf(axis.y) * half.y + fabsf(axis.z) * half.z;
}

/* What a cluster may send to a point: power over squared distance, times the cosines at which lights send and the point
 * receives. Near and in a cluster the distance says little, so it has a floor. The cosines lie between those of the
 * centre and the axis, which are right on the whole, and the largest there can be, which leave no light out; where
 * these are 0 there is nothing to receive. The shares were chosen by measured noise. A point in no surface has normal
 * 0. */
TY_FN float ty_light_node_importance(TY_GLOBAL const ty_light_node* node, ty_vec from, ty_vec normal) {
    const ty_vec to = ty_sub(node->center, from);
    const float d2 = ty_dot(to, to), d = sqrtf(d2);
    const float slack = TY_LIGHT_SLACK * (d + sqrtf(node->radius2));
    const float facing = ty_dot(normal, to), sending = -ty_dot(node->axis, to);
    if (facing + ty_light_extent(node->half, normal) < -slack) return 0.0f;
    /* Lights in one plane, or as good as: nothing goes behind it. */
    if (node->cos_o > 0.999999f && node->cos_e >= 0.0f && sending + ty_light_extent(node->half, node->axis) < -slack)
        return 0.0f;
    float importance = node->power / ty_maxf(ty_maxf(d2, 0.25f * node->radius2), 1e-18f);
    if (d2 <= node->radius2) return importance;
    float sine;
    const float sin_u = sqrtf(node->radius2) / d, cos_u = ty_light_sin_of(sin_u);
    if (ty_dot(normal, normal) > 0.0f) {
        const float mu = ty_clampf(facing / d, -1.0f, 1.0f);
        const float most = ty_light_cos_less(mu, ty_light_sin_of(mu), cos_u, sin_u, &sine);
        importance *= ty_maxf(ty_lerpf(ty_maxf(0.0f, mu), most, 0.7f), TY_LIGHT_SLACK);
    }
    if (node->cos_o <= -1.0f) return importance;
    float mu = ty_clampf(sending / d, -1.0f, 1.0f);
    mu = ty_light_cos_less(mu, ty_light_sin_of(mu), cos_u, sin_u, &sine);
    mu = ty_light_cos_less(mu, sine, node->cos_o, node->sin_o, &sine);
    if (mu < node->cos_e - TY_LIGHT_SLACK) return 0.0f;
    const float share = node->radius2 > 0.0f ? 0.3f : 1.0f; /* lamps without extent: exact */
    return importance * ty_maxf(ty_lerpf(ty_maxf(0.0f, sending / d), mu, share), TY_LIGHT_SLACK);
}

/* The probability of the first of two children; -1 where neither can send anything. One that can is never given up. */
TY_FN float ty_light_share(float first, float second) {
    if (!(first > 0.0f)) return second > 0.0f ? 0.0f : -1.0f;
    if (!(second > 0.0f)) return 1.0f;
    return ty_clampf(first / (first + second), 1e-6f, 1.0f - 1e-6f);
}

TY_FN float ty_light_tree_share(TY_GLOBAL const ty_light_node* nodes, int32_t node, ty_vec from, ty_vec normal) {
    return ty_light_share(ty_light_node_importance(&nodes[node + 1], from, normal),
                          ty_light_node_importance(&nodes[nodes[node].next], from, normal));
}

/* One step down: the child that *u takes, *u stretched back to [0, 1). */
TY_FN int32_t ty_light_tree_step(TY_GLOBAL const ty_light_node* nodes, int32_t node, float share, float* u,
                                 float* probability) {
    const bool first = *u < share;
    const float taken = first ? share : 1.0f - share;
    *u = ty_clampf((first ? *u : *u - share) / taken, 0.0f, 0x1.fffffep-1f);
    *probability *= taken;
    return first ? node + 1 : nodes[node].next;
}

/* Picks a light for point `from` on a surface with unit normal on the side that receives, or with normal 0 in a medium.
 * Each step uses some of the random bits of *u. nodes NULL: no lights. Returns -1, with probability 0, where the
 * descent finds nothing that can send light. */
TY_FN int32_t ty_light_tree_sample(TY_GLOBAL const ty_light_node* nodes, ty_vec from, ty_vec normal, float* u,
                                   float* probability) {
    int32_t node = 0;
    *probability = 0.0f;
    if (nodes == NULL) return -1;
    float product = 1.0f;
    while (nodes[node].next >= 0) {
        const float share = ty_light_tree_share(nodes, node, from, normal);
        if (share < 0.0f) return -1;
        node = ty_light_tree_step(nodes, node, share, u, &product);
    }
    *probability = product;
    return ~nodes[node].next;
}

/* The probability with which ty_light_tree_sample picks a light, by the same operations; 0 for lights outside the
 * tree. trails: ty_light_tree's. */
TY_FN float ty_light_tree_probability(TY_GLOBAL const ty_light_node* nodes, TY_GLOBAL const uint64_t* trails,
                                      int32_t light, ty_vec from, ty_vec normal) {
    uint64_t trail = trails[light];
    if (trail == TY_LIGHT_NO_TRAIL) return 0.0f;
    float product = 1.0f;
    for (int32_t node = 0; nodes[node].next >= 0; trail >>= 1) {
        const float share = ty_light_tree_share(nodes, node, from, normal);
        if (share < 0.0f) return 0.0f;
        product *= (trail & 1u) == 0 ? share : 1.0f - share;
        node = (trail & 1u) == 0 ? node + 1 : nodes[node].next;
    }
    return product;
}

/* What a cluster's lamps send to the stretch [enter, leave] of a ray: the integral of power over squared distance from
 * its centre, that is the angle under which it sees the stretch, over its distance to the ray. */
TY_FN float ty_light_node_ray_importance(TY_GLOBAL const ty_light_node* node, ty_vec origin, ty_vec direction,
                                         float enter, float leave) {
    const ty_vec to = ty_sub(node->center, origin);
    const float nearest = ty_dot(to, direction);
    const ty_vec beside = ty_mad(to, direction, -nearest);
    const float floor2 = 0.1f * node->radius2 + 1e-10f * ty_dot(to, to) + 1e-18f;
    const float off2 = ty_maxf(ty_dot(beside, beside), floor2), off = sqrtf(off2);
    const float angle = ty_atan2_over_2pi(off * (leave - enter), off2 + (enter - nearest) * (leave - nearest));
    return node->lamp_power * angle / off;
}

/* Picks a lamp for the light that it scatters into the stretch [enter, leave] of a ray. Returns -1, with probability 0,
 * where there is no lamp or no stretch. */
TY_FN int32_t ty_light_tree_sample_ray(TY_GLOBAL const ty_light_node* nodes, ty_vec origin, ty_vec direction,
                                       float enter, float leave, float* u, float* probability) {
    const float far = ty_minf(leave, 1e15f);
    int32_t node = 0;
    *probability = 0.0f;
    if (nodes == NULL || !(nodes[0].lamp_power > 0.0f) || !(far > enter)) return -1;
    float product = 1.0f;
    while (nodes[node].next >= 0) {
        const int32_t second = nodes[node].next;
        const float share =
            ty_light_share(ty_light_node_ray_importance(&nodes[node + 1], origin, direction, enter, far),
                           ty_light_node_ray_importance(&nodes[second], origin, direction, enter, far));
        if (share < 0.0f) return -1;
        node = ty_light_tree_step(nodes, node, share, u, &product);
    }
    *probability = product;
    return ~nodes[node].next;
}

#endif
