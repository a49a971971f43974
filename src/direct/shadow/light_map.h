/* Shadow maps in which straight lines are straight: tracing them, and where their texels lie. Other than those of
 * direct/shadow_map.h their texels are not of the same solid angle, but engines have such maps, too. */
#ifndef TY_DIRECT_LIGHT_MAP_H
#define TY_DIRECT_LIGHT_MAP_H

#include "scene/ray_counter.h"
#include "scene/scene.h"

#include <tyndall/light_map.h>

typedef struct ty_light_map_def {
    int32_t side;                /* texels, 1..8192 */
    bool reflective;             /* whether normals and albedo are found, too */
    const double *lower, *upper; /* directional lights: the map covers this box, m; not looked at for others */
} ty_light_map_def;

/* The map of a directional, point (six faces, a cube's) or spot light (an index into ty_light_set.lights) of a
 * committed scene, a ray through the middle of each texel; without surfaces nothing is met. Spots of more than 160
 * degrees have six faces, too, as points have; in others' corners, outside of the cone, nothing is met. counter:
 * NULL, or is added to. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. *out is freed with
 * ty_light_map_destroy. */
ty_result ty_light_map_trace(const ty_scene* scene, const ty_light_map_def* def, int32_t light, ty_light_map** out,
                             ty_ray_counter* counter);
void ty_light_map_destroy(ty_context* context, ty_light_map* map);

/* Whether a caller's map makes sense for a light; messages name it as maps[index]. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_light_map_check(ty_context* context, const ty_light_view* light, const ty_light_map* map, int32_t index);

/* The ray through a place of a face, in texels; direction is of such a length that depth counts in it. */
void ty_light_map_ray(const ty_light_map* map, const ty_light_view* light, int32_t face, float x, float y,
                      ty_vec* origin, ty_vec* direction);

/* What a texel stands for: solid angle, sr, seen from the light; of directional lights area across the light, m^2. */
float ty_light_map_share(const ty_light_map* map, const ty_light_view* light, int32_t face, int32_t x, int32_t y);

#endif
