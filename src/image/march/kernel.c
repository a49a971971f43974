/* The marcher's kernel; built once per instruction set, with TY_ISA naming it. */
#include "image/march/kernel.h"

#include "base/float_mode.h"
#include "image/march/pixel.k.h"

TY_MARCH_KERNEL(TY_KERNEL_NAME(ty_march_kernel)) {
    const unsigned state = ty_flush_denormals();
    const ty_accel* mesh = request->scene->mesh;
    uint64_t steps = 0;
    ty_march_ray ray;
    ray.steps = 0;
    for (int32_t x = begin; x < end; ++x) {
        ty_march_pixel* pixel = &pixels[x - begin];
        const int32_t rays = ty_pixel_rays(request, x, y);
        memset(pixel, 0, sizeof *pixel);
        for (int32_t i = 0; i < rays; ++i) {
            float dx, dy;
            ty_hit hit;
            if (rays == request->spp)
                ty_pixel_place(i, rays, &dx, &dy);
            else
                ty_pixel_place_at_edge(x, y, i, rays, &dx, &dy);
            const ty_vec direction = ty_camera_direction(&request->camera, (float)x + dx, (float)y + dy);
            const bool hits =
                mesh != NULL && ty_accel_intersect(mesh, request->camera.origin, direction, TY_FLOAT_MAX, &hit);
            ty_pixel_add_ray(request, &ray, direction, hits ? &hit : NULL, (float)x + dx, (float)y + dy,
                             ty_pixel_offset(request, x, y, i, rays), pixel);
            steps += ray.steps;
        }
        if (rays != request->spp) ty_pixel_scale(pixel, (float)request->spp / (float)rays);
    }
    ty_restore_denormals(state);
    return steps;
}
