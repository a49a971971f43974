/* Camera view for kernels. */
#ifndef TY_SCENE_CAMERA_H
#define TY_SCENE_CAMERA_H

#include "base/vector.k.h"

#include <tyndall/scene.h>

/* The ray through image point (x, y), in pixels from the top left, has direction corner + x dx + y dy. */
typedef struct ty_camera_view {
    ty_vec origin, corner, dx, dy;
    int32_t sampled;  /* nonzero: a thin lens or a moving camera, of which each ray takes one by ty_camera_sample */
    float aperture;   /* radius of the lens, m, over the length of dx */
    float per_focus;  /* 1 / distance of the plane in focus, 1/m */
    ty_vec motion[4]; /* origin, corner, dx and dy as the shutter closes, less those as it opens */
} ty_camera_view;

ty_result ty_camera_check(ty_context* context, const ty_camera_def** given, ty_camera_def* own);
ty_camera_view ty_camera_get_view(const ty_camera_def* def, int32_t width, int32_t height);
/* Fails for a lens or a moving camera: for methods whose rays all begin at one point. */
ty_result ty_camera_check_pinhole(ty_context* context, const ty_camera_def* def, const char* method);

static inline int32_t ty_camera_is_sampled(const ty_camera_def* def) {
    return def->aperture_radius > 0 || def->moves != 0;
}

TY_FN ty_vec ty_camera_direction(const ty_camera_view* camera, float x, float y) {
    return ty_normalize(ty_mad(ty_mad(camera->corner, camera->dx, x), camera->dy, y));
}

/* The pinhole at a point of the lens, (u, v) uniform in the unit square, and a time of the shutter, 0..1. All of these
 * see the plane in focus alike: from o + p its point o + F d is in direction d - p / F. */
TY_FN ty_camera_view ty_camera_sample(const ty_camera_view* camera, float u, float v, float time) {
    ty_camera_view out = *camera;
    float sine, cosine;
    out.origin = ty_mad(camera->origin, camera->motion[0], time);
    out.corner = ty_mad(camera->corner, camera->motion[1], time);
    out.dx = ty_mad(camera->dx, camera->motion[2], time);
    out.dy = ty_mad(camera->dy, camera->motion[3], time);
    ty_sincos_2pi(v, &sine, &cosine);
    const float radius = camera->aperture * sqrtf(u);
    const ty_vec lens = ty_mad(ty_scale(out.dx, radius * cosine), out.dy, radius * sine);
    out.origin = ty_add(out.origin, lens);
    out.corner = ty_mad(out.corner, lens, -camera->per_focus);
    return out;
}

#endif
