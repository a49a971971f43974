/* Pinhole camera. */
#include "scene/camera.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/check.h"

#include <math.h>

void ty_init_camera_def(void* def, size_t bytes) {
    const ty_camera_def own = {.position = {0, 0, 5}, .up = {0, 1, 0}, .fov_y = 40, .resolution = {800, 600}};
    ty_init_def(def, bytes, &own, sizeof own);
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double normalize(double v[3]) {
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; ++i) v[i] /= length;
    return length;
}

ty_result ty_camera_check(ty_context* context, const ty_camera_def** given, ty_camera_def* own) {
    *own = ty_default_camera_def();
    ty_result result = ty_take_def(context, *given, "ty_default_camera_def", own, sizeof *own);
    const ty_camera_def* def = *given = own;
    if (result == TY_OK) result = ty_check_point(context, "camera.position", def->position);
    if (result == TY_OK) result = ty_check_point(context, "camera.target", def->target);
    if (result == TY_OK) result = ty_check_direction(context, "camera.up", def->up);
    if (result == TY_OK) result = ty_check_number(context, "camera.exposure", def->exposure, -100, 100);
    if (result != TY_OK) return result;
    if (!(def->fov_y > 0 && def->fov_y < 180))
        return ty_fail(context, TY_ERROR_ARGUMENT, "camera.fov_y: %g is outside (0, 180)", def->fov_y);
    for (int i = 0; i < 2; ++i)
        if (def->resolution[i] < 1 || def->resolution[i] > 65536)
            return ty_fail(context, TY_ERROR_ARGUMENT, "camera.resolution[%d]: %d is outside [1, 65536]", i,
                           def->resolution[i]);
    double forward[3], right[3], up[3] = {def->up[0], def->up[1], def->up[2]};
    for (int i = 0; i < 3; ++i) forward[i] = def->target[i] - def->position[i];
    if (!(normalize(forward) > 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "camera.target: it is where the camera is");
    normalize(up);
    cross(forward, up, right);
    if (!(normalize(right) > 1e-6)) return ty_fail(context, TY_ERROR_ARGUMENT, "camera.up: it is along the view");
    return TY_OK;
}

ty_camera_view ty_camera_get_view(const ty_camera_def* def, int32_t width, int32_t height) {
    double forward[3], right[3], up[3];
    for (int i = 0; i < 3; ++i) forward[i] = def->target[i] - def->position[i];
    normalize(forward);
    cross(forward, def->up, right);
    normalize(right);
    cross(right, forward, up);
    const double half = tan(def->fov_y * (TY_PI_F64 / 360));
    const double pixel = 2 * half / height;
    ty_camera_view view;
    double corner[3], dx[3], dy[3];
    for (int i = 0; i < 3; ++i) {
        dx[i] = right[i] * pixel;
        dy[i] = -up[i] * pixel;
        corner[i] = forward[i] - dx[i] * width / 2 - dy[i] * height / 2;
    }
    view.origin = ty_vec_make((float)def->position[0], (float)def->position[1], (float)def->position[2]);
    view.corner = ty_vec_make((float)corner[0], (float)corner[1], (float)corner[2]);
    view.dx = ty_vec_make((float)dx[0], (float)dx[1], (float)dx[2]);
    view.dy = ty_vec_make((float)dy[0], (float)dy[1], (float)dy[2]);
    return view;
}
