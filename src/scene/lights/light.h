/* Validation and views of lights. */
#ifndef TY_SCENE_LIGHTS_LIGHT_H
#define TY_SCENE_LIGHTS_LIGHT_H

#include "scene/lights/environment.h"
#include "scene/lights/light.k.h"

#include <tyndall/scene.h>

/* Fails unless ty_scene_add_light accepts the light. */
ty_result ty_light_check(ty_context* context, const ty_light_def** given, ty_light_def* own);

/* True for lights that are committed as black surfaces: area lights, and lamps that have a radius. */
bool ty_light_is_surface(const ty_light_def* def);
/* That surface. */
ty_shape_def ty_light_shape(const ty_light_def* def);
/* View of a light that is no surface; environment may be NULL for other kinds. */
ty_light_view ty_light_get_view(const ty_light_def* def, const ty_environment* environment, ty_axis up);
/* Views of an emissive quad and sphere. */
ty_light_view ty_light_quad_view(const double origin[3], const double u[3], const double v[3], const float radiance[3]);
ty_light_view ty_light_sphere_view(const double center[3], double radius, const float radiance[3]);
/* Limits a view to the cone of a spot. */
void ty_light_set_cone(const ty_light_def* def, ty_light_view* view);
/* View of a triangle of an emissive mesh; false if it has no area or no emission. surface must outlive it. */
bool ty_light_triangle_view(const ty_surface* surface, int32_t triangle, ty_light_view* out);

/* Sets the fields that depend on the scene box [lower, upper]: `typical` and `reach2`, and `chosen` and `cumulative` of
 * distant lights. Probabilities are proportional to the unshadowed fluence at a typical distance from the box, with a
 * tenth distributed uniformly; 0 for lights that are better hit than sampled. Returns the total probability of
 * positioned lights. */
float ty_light_set_choice(ty_light_view* lights, size_t count, const double lower[3], const double upper[3]);

#endif
