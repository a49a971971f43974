/* The marcher's kernel of lenses and moving cameras: each ray has a camera of its own. */
#include "image/march/kernel.h"

#include "base/float_mode.h"
#include "image/march/pixel.k.h"

TY_MARCH_KERNEL(TY_KERNEL_NAME(ty_march_sampled_kernel)) {
    const unsigned state = ty_flush_denormals();
    const ty_accel* mesh = request->scene->mesh;
    ty_march_request own = *request;
    uint64_t steps = 0;
    ty_march_ray ray;
    ray.steps = 0;
    for (int32_t x = begin; x < end; ++x) {
        ty_march_pixel* pixel = &pixels[x - begin];
        memset(pixel, 0, sizeof *pixel);
        for (int32_t i = 0; i < request->spp; ++i) {
            float dx, dy;
            ty_hit hit;
            ty_pixel_place(i, request->spp, &dx, &dy);
            own.camera = ty_pixel_camera(&request->camera, x, y, i);
            const ty_vec direction = ty_camera_direction(&own.camera, (float)x + dx, (float)y + dy);
            const bool hits =
                mesh != NULL && ty_accel_intersect(mesh, own.camera.origin, direction, TY_FLOAT_MAX, &hit);
            ty_pixel_add_ray(&own, &ray, direction, hits ? &hit : NULL, (float)x + dx, (float)y + dy,
                             ty_pixel_offset(request, x, y, i, request->spp), pixel);
            steps += ray.steps;
        }
    }
    ty_restore_denormals(state);
    return steps;
}
