/* Choosing among a scene's lights. */
#ifndef TY_SCENE_LIGHT_CHOICE_K_H
#define TY_SCENE_LIGHT_CHOICE_K_H

#include "scene/light_tree.k.h"

/* All lights of a scene. Those without a place (directional, environments) are chosen with a fixed probability, those
 * with one by a tree. */
typedef struct ty_light_set {
    TY_GLOBAL const ty_light_view* lights;
    int32_t count;
    TY_GLOBAL const int32_t* distant; /* lights without a place */
    int32_t distant_count;
    TY_GLOBAL const ty_light_node* nodes; /* NULL: no light has a place */
    TY_GLOBAL const uint64_t* trails;     /* per light */
    float placed;                         /* probability of going to the tree */
    int32_t local_count;                  /* lights that ty_light_is_local counts */
} ty_light_set;

/* Picks a light for point `from`, on a surface with normal (0 in a medium); *u is stretched back to [0, 1). Returns -1
 * where no light is chosen. */
TY_FN int32_t ty_lights_choose(TY_GLOBAL const ty_light_set* set, ty_vec from, ty_vec normal, float* u,
                               float* probability) {
    if (*u < set->placed) {
        *u = ty_minf(*u / set->placed, 0x1.fffffep-1f);
        const int32_t light = ty_light_tree_sample(set->nodes, from, normal, u, probability);
        *probability *= set->placed;
        return light;
    }
    for (int32_t i = 0; i < set->distant_count; ++i) {
        TY_GLOBAL const ty_light_view* light = &set->lights[set->distant[i]];
        if (!(light->chosen > 0.0f) || *u >= light->cumulative) continue;
        *u = ty_clampf((*u - (light->cumulative - light->chosen)) / light->chosen, 0.0f, 0x1.fffffep-1f);
        *probability = light->chosen;
        return set->distant[i];
    }
    return -1;
}

/* The probability with which ty_lights_choose picks a light that has a place. */
TY_FN float ty_lights_probability(TY_GLOBAL const ty_light_set* set, int32_t light, ty_vec from, ty_vec normal) {
    return set->placed * ty_light_tree_probability(set->nodes, set->trails, light, from, normal);
}

/* Picks a lamp for the light that it scatters into the stretch [enter, leave] of a ray; -1 where there is none. */
TY_FN int32_t ty_lights_choose_local(TY_GLOBAL const ty_light_set* set, ty_vec origin, ty_vec direction, float enter,
                                     float leave, float* u, float* probability) {
    return ty_light_tree_sample_ray(set->nodes, origin, direction, enter, leave, u, probability);
}

#endif
