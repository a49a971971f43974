/* Discretised lights: every light of a scene stands for a few samples of it, each a direction or a point, from which
 * its light is computed one sample after another. */
#ifndef TY_DIRECT_LIGHTS_DISCRETE_LIGHT_H
#define TY_DIRECT_LIGHTS_DISCRETE_LIGHT_H

#include "scene/lights/light.k.h"

#include <tyndall/base.h>

typedef enum ty_discrete_light_kind { TY_DISCRETE_DIRECTIONAL = 0, TY_DISCRETE_POINT = 1 } ty_discrete_light_kind;

/* Intensity of a point by the cosine mu about its direction, relative to its maximum: 1, a spot's falloff, max(0, mu),
 * |mu|. */
typedef enum ty_light_profile {
    TY_PROFILE_ISOTROPIC = 0,
    TY_PROFILE_SPOT = 1,
    TY_PROFILE_COSINE = 2,
    TY_PROFILE_TWO_SIDED = 3
} ty_light_profile;

/* One direction or one point of a light. */
typedef struct ty_discrete_light {
    int32_t kind;       /* ty_discrete_light_kind */
    int32_t light;      /* index into ty_light_set.lights; of a VPL, the light that its surface reflects */
    float color[3];     /* directional: irradiance, W m^-2; point: maximum of the intensity, W sr^-1 */
    ty_vec direction;   /* directional: direction of travel; point: axis of the profile; unit */
    ty_vec position;    /* point, m */
    float mean_cosine;  /* of the sampled light about its direction, 0..1; 1: a line */
    float area;         /* point: surface area that it stands for, m^2; 0: none */
    float min_distance; /* point: distance below which 1 / r^2 is clamped, m */
    int32_t profile;    /* point: ty_light_profile */
    int32_t is_point;   /* point: the light is this point itself, not a surface around it */
    int32_t is_virtual; /* a VPL: its light is reflected, not emitted */
    int32_t shadowed;   /* surfaces of the scene cast shadows from it */
} ty_discrete_light;

/* A list that owns its items. */
typedef struct ty_discrete_light_set {
    ty_discrete_light* items;
    int32_t count, capacity;
} ty_discrete_light_set;

/* An empty set with memory for `capacity` items. what: begins the message where these are too many. Errors:
 * TY_ERROR_ARGUMENT (more than INT32_MAX), TY_ERROR_MEMORY. */
ty_result ty_discrete_light_set_create(ty_context* context, const char* what, int64_t capacity,
                                       ty_discrete_light_set* out);
/* Frees the items; a set of zeros is allowed. */
void ty_discrete_light_set_destroy(ty_context* context, ty_discrete_light_set* set);

/* A kind's profile at cosine mu from its direction. light: the scene's light that a spot's falloff is read from. */
TY_FN float ty_light_profile_at(int32_t profile, const ty_light_view* light, float mu) {
    if (profile == TY_PROFILE_ISOTROPIC) return 1.0f;
    if (profile == TY_PROFILE_SPOT) return ty_spot_falloff(light, mu);
    return profile == TY_PROFILE_TWO_SIDED ? fabsf(mu) : ty_maxf(0.0f, mu);
}

#endif
