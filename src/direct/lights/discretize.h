/* A scene's lights taken apart into beams (parallel light from infinity) and lamps (light from a point), which is what
 * uncollided light is computed from, one at a time. */
#ifndef TY_DIRECT_LIGHTS_DISCRETIZE_H
#define TY_DIRECT_LIGHTS_DISCRETIZE_H

#include "scene/light.k.h"

#include <tyndall/scene.h>

typedef enum ty_source_kind { TY_SOURCE_BEAM = 0, TY_SOURCE_LAMP = 1 } ty_source_kind;

typedef struct ty_source {
    ty_source_kind kind;
    int32_t light;    /* which of the scene's lights it is part of: an index into ty_light_set.lights */
    float color[3];   /* beams: irradiance, W m^-2; lamps: intensity where they are brightest, W sr^-1 */
    ty_vec direction; /* beams: the way light travels; points on surfaces: the unit normal, else as the light has it */
    ty_vec position;  /* lamps, m */
    int32_t alone;    /* lamps: whether the light is this one point, not one of many on a surface */
    const ty_light_view* stand_in; /* lamps that are no light of the scene: whose profile they have; NULL: are one */
    float area;                    /* lamps: of the surface that the point stands for, m^2; 0: none */
    float cosine; /* beams: mean cosine of the light that they stand for about the direction; 1: it is a line */
} ty_source;

typedef struct ty_source_def {
    int32_t environment; /* beams per environment light, 1..65536 */
    int32_t surface;     /* points per area light and glowing sphere, 1..65536; all glowing triangles together get four
                            times as many, in proportion to their power */
    uint64_t seed;
} ty_source_def;

/* 64 beams, 16 points. */
ty_source_def ty_default_source_def(void);

/* Beams and lamps of all lights of a committed scene, in the lights' order. They are points of a Sobol sequence, so the
 * same call gives the same ones, and twice as many are the same and as many more between them.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. *out is freed with ty_sources_destroy. */
ty_result ty_sources_create(const ty_scene* scene, const ty_source_def* def, ty_source** out, int32_t* count);
void ty_sources_destroy(ty_context* context, ty_source* sources, int32_t count);

/* How bright a lamp is at cosine mu from its direction, relative to its color. */
TY_FN float ty_source_profile(const ty_light_view* light, float mu) {
    if (light->kind == TY_KIND_POINT) return 1.0f;
    if (light->kind == TY_KIND_SPOT) return ty_spot_falloff(light, mu);
    return light->kind == TY_KIND_TRIANGLE && light->two_sided != 0 ? fabsf(mu) : ty_maxf(0.0f, mu);
}

#endif
