/* Points of an image at which irradiance is gathered; built once per instruction set, with TY_ISA naming it. */
#include "image/march/gathered.h"

#include "base/float_mode.h"
#include "image/march/pixel.k.h"

TY_GATHERED_KERNEL(TY_KERNEL_NAME(ty_gathered_kernel)) {
    const unsigned state = ty_flush_denormals();
    const ty_gathered_view* view = &request->gathered;
    const float y = (float)ty_gathered_pixel(row, view->height) + 0.5f;
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t i = 0; i < view->columns; ++i) {
        const ty_vec direction =
            ty_camera_direction(&request->camera, (float)ty_gathered_pixel(i, view->width) + 0.5f, y);
        ty_gathered_point* point = &view->points[row * view->columns + i];
        ty_surface_point surface;
        ty_hit hit;
        point->exists = 0;
        if (!ty_accel_intersect(request->scene->mesh, request->camera.origin, direction, TY_FLOAT_MAX, &hit)) continue;
        const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit.position);
        if (ty_cell_inside(&request->surface_field.lattice, cells)) continue;
        ty_surface_evaluate(&request->scene->surfaces[hit.surface], &hit, direction, &surface);
        point->exists = 1;
        point->position = hit.position;
        point->normal = surface.ns;
        point->distance = hit.distance;
        steps +=
            ty_reflect_gather(request, &ray, ty_hit_leave(&hit, surface.ng), surface.ng, surface.ns, TY_REFLECT_RAYS,
                              ty_pixel_offset(request, i, row, 0, request->spp), point->irradiance);
    }
    ty_restore_denormals(state);
    return steps;
}
