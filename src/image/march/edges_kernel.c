/* Faces of thick media that the rays of pixels enter; built once per instruction set, with TY_ISA naming it. */
#include "image/march/edges.h"

#include "image/march/edges.k.h"

TY_EDGES_KERNEL(TY_KERNEL_NAME(ty_edges_kernel)) {
    const ty_camera_view* camera = &request->camera;
    for (int32_t x = -1; x <= width; ++x, ++faces) {
        const ty_vec direction = ty_camera_direction(camera, (float)x + 0.5f, (float)y + 0.5f);
        const float pixel = ty_edges_pixel(camera, (float)x + 0.5f, (float)y + 0.5f);
        float distance;
        *faces = ty_edges_face(request, direction, pixel, &distance);
        if (*faces != 0 && request->scene->mesh != NULL &&
            ty_accel_occluded(request->scene->mesh, request->camera.origin, direction, distance))
            *faces = 0;
    }
}
