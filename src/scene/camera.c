/* Cameras: pinholes and thin lenses, at rest or moving. */
#include "scene/camera.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/check.h"

#include <math.h>

void ty_init_camera_def(void* def, size_t bytes) {
    const ty_camera_def own = {.position = {0, 0, 5},
                               .up = {0, 1, 0},
                               .fov_y = 40,
                               .resolution = {800, 600},
                               .end_position = {0, 0, 5},
                               .end_up = {0, 1, 0}};
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

static ty_result check_pose(ty_context* context, const char* const names[3], const double position[3],
                            const double target[3], const double given_up[3]) {
    ty_result result = ty_check_point(context, names[0], position);
    if (result == TY_OK) result = ty_check_point(context, names[1], target);
    if (result == TY_OK) result = ty_check_direction(context, names[2], given_up);
    if (result != TY_OK) return result;
    double forward[3], right[3], up[3] = {given_up[0], given_up[1], given_up[2]};
    for (int i = 0; i < 3; ++i) forward[i] = target[i] - position[i];
    if (!(normalize(forward) > 0))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: it is where the camera is", names[1]);
    normalize(up);
    cross(forward, up, right);
    if (!(normalize(right) > 1e-6)) return ty_fail(context, TY_ERROR_ARGUMENT, "%s: it is along the view", names[2]);
    return TY_OK;
}

ty_result ty_camera_check(ty_context* context, const ty_camera_def** given, ty_camera_def* own) {
    *own = ty_default_camera_def();
    ty_result result = ty_take_def(context, *given, "ty_default_camera_def", own, sizeof *own);
    const ty_camera_def* def = *given = own;
    static const char* const names[3] = {"camera.position", "camera.target", "camera.up"};
    static const char* const end_names[3] = {"camera.end_position", "camera.end_target", "camera.end_up"};
    if (result == TY_OK) result = check_pose(context, names, def->position, def->target, def->up);
    if (result == TY_OK && def->moves != 0)
        result = check_pose(context, end_names, def->end_position, def->end_target, def->end_up);
    for (int i = 0; i < 2 && result == TY_OK; ++i)
        result = ty_check_number(context, i == 0 ? "camera.shift[0]" : "camera.shift[1]", def->shift[i], -100, 100);
    if (result == TY_OK) result = ty_check_number(context, "camera.aperture_radius", def->aperture_radius, 0, 1e9);
    if (result == TY_OK) result = ty_check_number(context, "camera.focus_distance", def->focus_distance, 0, 1e9);
    if (result == TY_OK) result = ty_check_number(context, "camera.exposure", def->exposure, -100, 100);
    if (result != TY_OK) return result;
    if (!(def->fov_y > 0 && def->fov_y < 180))
        return ty_fail(context, TY_ERROR_ARGUMENT, "camera.fov_y: %g is outside (0, 180)", def->fov_y);
    for (int i = 0; i < 2; ++i)
        if (def->resolution[i] < 1 || def->resolution[i] > 65536)
            return ty_fail(context, TY_ERROR_ARGUMENT, "camera.resolution[%d]: %d is outside [1, 65536]", i,
                           def->resolution[i]);
    return TY_OK;
}

ty_result ty_camera_check_pinhole(ty_context* context, const ty_camera_def* def, const char* method) {
    if (!ty_camera_is_sampled(def)) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT,
                   "%s: the camera has an aperture or moves, which path, dom, fld, cda and pop show", method);
}

/* Origin, corner, dx and dy of a pose. */
static void place(const ty_camera_def* def, const double position[3], const double target[3], const double given_up[3],
                  int32_t width, int32_t height, double out[4][3]) {
    double forward[3], right[3], up[3];
    for (int i = 0; i < 3; ++i) forward[i] = target[i] - position[i];
    normalize(forward);
    cross(forward, given_up, right);
    normalize(right);
    cross(right, forward, up);
    const double half = tan(def->fov_y * (TY_PI_F64 / 360));
    const double pixel = 2 * half / height;
    for (int i = 0; i < 3; ++i) {
        double* dx = &out[2][i];
        double* dy = &out[3][i];
        out[0][i] = position[i];
        *dx = right[i] * pixel;
        *dy = -up[i] * pixel;
        out[1][i] = forward[i] - *dx * width / 2 - *dy * height / 2;
        if (def->shift[0] != 0 || def->shift[1] != 0)
            out[1][i] += 2 * half * (right[i] * def->shift[0] + up[i] * def->shift[1]);
    }
}

static ty_vec vec_of(const double v[3]) {
    return ty_vec_make((float)v[0], (float)v[1], (float)v[2]);
}

/* Distance of the plane in focus, m. */
static double focus_of(const ty_camera_def* def) {
    double forward[3];
    for (int i = 0; i < 3; ++i) forward[i] = def->target[i] - def->position[i];
    return def->focus_distance > 0 ? def->focus_distance : normalize(forward);
}

ty_camera_view ty_camera_get_view(const ty_camera_def* def, int32_t width, int32_t height) {
    double open[4][3], closed[4][3];
    place(def, def->position, def->target, def->up, width, height, open);
    ty_camera_view view = {.origin = vec_of(open[0]),
                           .corner = vec_of(open[1]),
                           .dx = vec_of(open[2]),
                           .dy = vec_of(open[3]),
                           .sampled = ty_camera_is_sampled(def)};
    if (view.sampled == 0) return view;
    view.aperture = (float)(def->aperture_radius / (2 * tan(def->fov_y * (TY_PI_F64 / 360)) / height));
    view.per_focus = (float)(1 / focus_of(def));
    if (def->moves == 0) return view;
    place(def, def->end_position, def->end_target, def->end_up, width, height, closed);
    for (int k = 0; k < 4; ++k) {
        for (int i = 0; i < 3; ++i) closed[k][i] -= open[k][i];
        view.motion[k] = vec_of(closed[k]);
    }
    return view;
}
