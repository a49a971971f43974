/* Lights on their way into a scene. */
#ifndef TY_SCENE_LIGHT_H
#define TY_SCENE_LIGHT_H

#include "scene/environment.h"
#include "scene/light.k.h"

#include <tyndall/scene.h>

/* Fails unless a light is one that ty_scene_add_light promises to take. */
ty_result ty_light_check(ty_context* context, const ty_light_def** given, ty_light_def* own);

/* A light's view; environment may be NULL for other kinds. */
ty_light_view ty_light_get_view(const ty_light_def* def, const ty_environment* environment, ty_axis up);
/* Views of an emissive quad and sphere. */
ty_light_view ty_light_quad_view(const double origin[3], const double u[3], const double v[3], const float radiance[3]);
ty_light_view ty_light_sphere_view(const double center[3], double radius, const float radiance[3]);
/* The view of an emissive mesh's triangle; false when it has no area or sends nothing. surface must outlive it. */
bool ty_light_triangle_view(const ty_surface* surface, int32_t triangle, ty_light_view* out);

/* Sets what lights are to the box [lower, upper]: `typical` and `reach2`, and `chosen` and `cumulative` of those
 * without a place. Probabilities go by each light's fluence, unshadowed, at a typical distance from what lies in the
 * box, with a tenth shared evenly; 0 for lights that are better met than sampled. Returns the probability of all lights
 * with a place together. */
float ty_light_set_choice(ty_light_view* lights, size_t count, const double lower[3], const double upper[3]);

#endif
