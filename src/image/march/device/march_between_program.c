/* Pixels between rays, on devices. */
#include "image/march/device/item.k.h"
#include "image/march/spaced.k.h"

TY_DEVICE_ENTRY(march_between, ty_march_launch) {
    TY_GLOBAL const ty_march_request* request = arguments->request;
    const ty_accel* mesh = request->scene->mesh;
    const int32_t x = ty_march_column(arguments, index, arguments->width);
    const int32_t y = ty_march_row(arguments, index, arguments->width);
    const ty_vec direction = ty_spaced_direction(request, x, y, arguments->sample);
    ty_march_ray ray;
    ty_march_pixel pixel;
    ty_hit hit;
    const bool hits = mesh != NULL && ty_accel_intersect(mesh, request->camera.origin, direction, TY_FLOAT_MAX, &hit);
    if (arguments->sample > 0)
        pixel = arguments->sums[arguments->begin + index];
    else
        memset(&pixel, 0, sizeof pixel);
    ty_march_count(arguments, index,
                   ty_spaced_fill(request, &ray, &arguments->lattice, arguments->sample, x, y, direction,
                                  hits ? &hit : NULL, &pixel));
    if (arguments->last != 0)
        ty_march_store(arguments, index, &pixel);
    else
        arguments->sums[arguments->begin + index] = pixel;
}
