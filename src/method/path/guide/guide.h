/* The guide of paths: light on cells from a coarse solve by discrete ordinates, and from it the radiance that comes
 * from each of a set of directions to cells, along rays through cells and to surfaces. */
#ifndef TY_METHOD_PATH_GUIDE_GUIDE_H
#define TY_METHOD_PATH_GUIDE_GUIDE_H

#include "method/path/trace/kernel.h"

#include <tyndall/scene.h>

typedef struct ty_path_guide {
    ty_context* context;
    ty_guide view;
    float* radiance;
    ty_guide_light* light;
    size_t cells;
} ty_path_guide;

/* The guide of a committed scene with media; view: the scene as paths see it. Errors: TY_ERROR_MEMORY. */
ty_result ty_path_guide_create(const ty_scene* scene, const ty_scene_view* view, uint64_t seed, ty_path_guide** out);
void ty_path_guide_destroy(ty_path_guide* guide);

#endif
