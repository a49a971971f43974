/* Choosing among a scene's lights. */
#ifndef TY_SCENE_LIGHT_CHOICE_K_H
#define TY_SCENE_LIGHT_CHOICE_K_H

#include "scene/light.k.h"

/* All lights of a scene. Those without a place (directional, environments) are chosen with a fixed probability. */
typedef struct ty_light_set {
    TY_GLOBAL const ty_light_view* lights;
    int32_t count;
    TY_GLOBAL const int32_t* distant; /* lights without a place */
    int32_t distant_count;
    int32_t lamp_count; /* that ty_light_is_lamp counts */
    float lamp_share;
} ty_light_set;

/* Picks a light for point `from`, on a surface with normal (0 in a medium); *u is stretched back to [0, 1). Returns -1
 * where no light can be chosen. */
TY_FN int32_t ty_lights_choose(TY_GLOBAL const ty_light_set* set, ty_vec from, ty_vec normal, float* u,
                               float* probability) {
    (void)from;
    (void)normal;
    if (set->count == 0) return -1;
    int32_t i = 0;
    while (i + 1 < set->count && *u >= set->lights[i].cumulative) ++i;
    TY_GLOBAL const ty_light_view* light = &set->lights[i];
    if (!(light->chosen > 0.0f)) return -1;
    *u = ty_clampf((*u - (light->cumulative - light->chosen)) / light->chosen, 0.0f, 0x1.fffffep-1f);
    *probability = light->chosen;
    return i;
}

/* The probability with which ty_lights_choose picks a light. */
TY_FN float ty_lights_probability(TY_GLOBAL const ty_light_set* set, int32_t light, ty_vec from, ty_vec normal) {
    (void)from;
    (void)normal;
    return set->lights[light].chosen;
}

TY_FN int32_t ty_lights_choose_lamp(TY_GLOBAL const ty_light_set* set, ty_vec origin, ty_vec direction, float enter,
                                    float leave, float* u, float* probability) {
    (void)origin;
    (void)direction;
    (void)enter;
    (void)leave;
    int32_t lamp = -1;
    for (int32_t i = 0; i < set->count; ++i) {
        if (!ty_light_is_lamp(set->lights[i].kind)) continue;
        lamp = i;
        *u -= set->lights[i].chosen * set->lamp_share;
        if (*u < 0.0f) break;
    }
    if (lamp >= 0) *probability = set->lights[lamp].chosen * set->lamp_share;
    return lamp;
}

#endif
