/* The lights of a scene as discrete samples: directions and points. */
#ifndef TY_DIRECT_LIGHTS_DISCRETIZE_H
#define TY_DIRECT_LIGHTS_DISCRETIZE_H

#include "direct/lights/discrete_light.h"

#include <tyndall/scene.h>

typedef struct ty_discretize_def {
    int32_t environment; /* directions per environment light, 1..65536 */
    int32_t surface;     /* points per area light and emissive sphere, 1..65536; all emissive triangles together get
                            four times as many, in proportion to their power */
    uint64_t seed;
} ty_discretize_def;

/* 64 directions, 16 points. */
ty_discretize_def ty_default_discretize_def(void);

/* Samples of all lights of a committed scene, in the lights' order. They are points of a Sobol sequence: the same call
 * gives the same samples, and a doubled count keeps the first half. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. *out is
 * freed with ty_discrete_light_set_destroy, also after an error. */
ty_result ty_discretize_lights(const ty_scene* scene, const ty_discretize_def* def, ty_discrete_light_set* out);

#endif
