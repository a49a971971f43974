/* Reflective shadow maps in perspective (or parallel) projection, which maps straight lines to straight lines: tracing,
 * checking and projecting them. The candidates for virtual point lights, stratified by solid angle, are no map that
 * anyone looks up: see direct/lights/vpl_samples.h. */
#ifndef TY_DIRECT_SHADOW_RSM_H
#define TY_DIRECT_SHADOW_RSM_H

#include "scene/surfaces/ray_counter.h"
#include "scene/scene.h"

#include <tyndall/rsm.h>

typedef struct ty_rsm_def {
    int32_t side;                /* texels, 1..8192 */
    bool reflective;             /* whether normals and albedo are stored, too */
    const double *lower, *upper; /* directional lights: the map covers this box, m; ignored for others */
} ty_rsm_def;

/* Traces the map of a directional, point (six cube faces) or spot light of a committed scene, with one ray through the
 * center of each texel. light: an index into ty_light_set.lights. Spot lights wider than 160 degrees get six faces,
 * too; the corners of a spot light's face outside the cone stay empty. counter: NULL, or a counter of the rays. Errors:
 * TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. *out is freed with ty_rsm_destroy. */
ty_result ty_rsm_trace(const ty_scene* scene, const ty_rsm_def* def, int32_t light, ty_rsm** out,
                       ty_ray_counter* counter);
void ty_rsm_destroy(ty_context* context, ty_rsm* map);

/* Checks a caller's map against its light; messages name it maps[index]. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_rsm_check(ty_context* context, const ty_light_view* light, const ty_rsm* map, int32_t index);

/* The ray through a point of a face, in texels. The length of the direction is 1 along forward, so that origin + depth
 * * direction is the surface point. */
void ty_rsm_ray(const ty_rsm* map, const ty_light_view* light, int32_t face, float x, float y, ty_vec* origin,
                ty_vec* direction);

/* The solid angle of a texel seen from the light, sr; for directional lights its area across the light, m^2. */
float ty_rsm_texel_measure(const ty_rsm* map, const ty_light_view* light, int32_t face, int32_t x, int32_t y);

#endif
