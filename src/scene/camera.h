/* Camera view for kernels. */
#ifndef TY_SCENE_CAMERA_H
#define TY_SCENE_CAMERA_H

#include "base/vector.k.h"

#include <tyndall/scene.h>

/* The ray through image point (x, y), in pixels from the top left, has direction corner + x dx + y dy. */
typedef struct ty_camera_view {
    ty_vec origin, corner, dx, dy;
} ty_camera_view;

ty_result ty_camera_check(ty_context* context, const ty_camera_def** given, ty_camera_def* own);
ty_camera_view ty_camera_get_view(const ty_camera_def* def, int32_t width, int32_t height);

TY_FN ty_vec ty_camera_direction(const ty_camera_view* camera, float x, float y) {
    return ty_normalize(ty_mad(ty_mad(camera->corner, camera->dx, x), camera->dy, y));
}

#endif
