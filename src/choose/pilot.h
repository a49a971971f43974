/* A pilot of path tracing: a small picture, whose noise and length of paths the choice of a method rests on. */
#ifndef TY_CHOOSE_PILOT_H
#define TY_CHOOSE_PILOT_H

#include <tyndall/choose.h>

/* Pictures of about 768 pixels in the camera's aspect ratio. The caller destroys both. */
typedef struct ty_pilot {
    ty_image* all;         /* with the channels of TY_AOV_MULTIPLE and TY_AOV_VARIANCE */
    ty_image* unscattered; /* light that no medium scattered or emitted; NULL without surfaces */
    int32_t width, height, spp;
} ty_pilot;

/* Traces a pilot of a committed scene, of at least 4 samples per pixel and about so many interactions with surfaces and
 * media, and fills in the features noise, multiple, vertices, unscattered, surface_noise and surface_vertices. Errors:
 * those of ty_path_render; *out is to be freed in any case. */
ty_result ty_pilot_trace(const ty_scene* scene, double interactions, ty_pilot* out, ty_scene_features* features);
void ty_pilot_free(ty_pilot* pilot);

#endif
