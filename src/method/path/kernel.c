/* The path tracer's kernel; built once per instruction set, with TY_ISA naming it. */
#include "method/path/path.k.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

static void start(ty_path* path, const ty_path_request* request, int64_t item) {
    if (request->kind == TY_PATH_PIXELS) {
        const int32_t x = request->crop[0] + (int32_t)(item % request->crop[2]);
        const int32_t y = request->crop[1] + (int32_t)(item / request->crop[2]);
        const float dx = ty_random_next(&path->random), dy = ty_random_next(&path->random);
        path->origin = request->camera.origin;
        path->direction = ty_camera_direction(&request->camera, (float)x + dx, (float)y + dy);
    } else if (request->kind == TY_PATH_RAYS) {
        const double* ray = request->rays + 6 * item;
        const double length = sqrt(ray[3] * ray[3] + ray[4] * ray[4] + ray[5] * ray[5]);
        path->origin = ty_vec_make((float)ray[0], (float)ray[1], (float)ray[2]);
        path->direction = ty_vec_make((float)(ray[3] / length), (float)(ray[4] / length), (float)(ray[5] / length));
    } else {
        float point[3];
        int64_t rest = item;
        for (int a = 0; a < 3; ++a) {
            const int64_t index = rest % request->size[a];
            rest /= request->size[a];
            const float offset = request->cell[a] > 0 ? ty_random_next(&path->random) : 0.5f;
            point[a] = (float)(request->lower[a] + request->cell[a] * ((double)index + (double)offset));
        }
        ty_path_begin_fluence(path, ty_vec_make(point[0], point[1], point[2]));
    }
}

/* The number that an item's random numbers come from: a pixel's does not depend on the crop. */
static uint64_t random_item(const ty_path_request* request, int64_t item) {
    if (request->kind != TY_PATH_PIXELS) return (uint64_t)item;
    const int64_t x = request->crop[0] + item % request->crop[2], y = request->crop[1] + item / request->crop[2];
    return (uint64_t)(y * request->width + x);
}

TY_PATH_KERNEL(TY_JOIN(ty_path_kernel_, TY_ISA)) {
    const unsigned thread_state = ty_mesh_enter_thread();
    uint64_t vertices = 0;
    for (int64_t item = begin; item < end; ++item) {
        const uint64_t number = random_item(request, item);
        ty_path_sums* sum = &sums[item - begin];
        for (uint32_t i = 0; i < count; ++i) {
            ty_path path;
            ty_path_begin(&path, request, number, first_sample + i);
            start(&path, request, item);
            vertices += ty_path_follow(&path);
            for (int c = 0; c < 3; ++c) {
                const double value = (double)path.uncollided[c] + (double)path.collided[c];
                sum->mean[c] += value;
                sum->square[c] += value * value;
                if (parts != NULL) parts[item - begin].uncollided[c] += (double)path.uncollided[c];
            }
        }
    }
    ty_mesh_leave_thread(thread_state);
    return vertices;
}
