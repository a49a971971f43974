/* Selection among the lights of a scene. */
#ifndef TY_SCENE_LIGHTS_LIGHT_CHOICE_K_H
#define TY_SCENE_LIGHTS_LIGHT_CHOICE_K_H

#include "scene/lights/light_tree.k.h"

/* All lights of a scene. Distant ones (directional, environments) have fixed selection probabilities, positioned ones
 * are selected by a tree. */
typedef struct ty_light_set {
    TY_GLOBAL const ty_light_view* lights;
    int32_t count;
    TY_GLOBAL const int32_t* distant; /* distant lights */
    int32_t distant_count;
    TY_GLOBAL const ty_light_node* nodes; /* NULL: no positioned lights */
    TY_GLOBAL const uint64_t* trails;     /* per light */
    float tree_probability;               /* probability of sampling the tree */
    int32_t local_count;                  /* number of lights for which ty_light_is_local holds */
} ty_light_set;

/* Selects a light for point `from`, on a surface with this normal (0 in a medium) and, if it is glossy, lobe; *u is
 * rescaled to [0, 1). Returns -1 if no light is selected. */
TY_FN int32_t ty_lights_choose(TY_GLOBAL const ty_light_set* set, ty_vec from, ty_vec normal, const ty_light_lobe* lobe,
                               float* u, float* probability) {
    if (*u < set->tree_probability) {
        *u = ty_minf(*u / set->tree_probability, 0x1.fffffep-1f);
        const int32_t light = ty_light_tree_sample(set->nodes, from, normal, lobe, u, probability);
        *probability *= set->tree_probability;
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

/* Probability with which ty_lights_choose selects a positioned light. */
TY_FN float ty_lights_probability(TY_GLOBAL const ty_light_set* set, int32_t light, ty_vec from, ty_vec normal,
                                  const ty_light_lobe* lobe) {
    return set->tree_probability * ty_light_tree_probability(set->nodes, set->trails, light, from, normal, lobe);
}

/* Selects a local light for single scattering along [enter, leave] of a ray; -1 if there is none. */
TY_FN int32_t ty_lights_choose_local(TY_GLOBAL const ty_light_set* set, ty_vec origin, ty_vec direction, float enter,
                                     float leave, float* u, float* probability) {
    return ty_light_tree_sample_ray(set->nodes, origin, direction, enter, leave, u, probability);
}

/* Probability with which ty_lights_choose_local selects a local light. */
TY_FN float ty_lights_local_probability(TY_GLOBAL const ty_light_set* set, int32_t light, ty_vec origin,
                                        ty_vec direction, float enter, float leave) {
    return ty_light_tree_ray_probability(set->nodes, set->trails, light, origin, direction, enter, leave);
}

#endif
