/* Pixels by rays of their own, on devices. */
#include "image/march/device/item.k.h"

TY_DEVICE_ENTRY(march_pixels, ty_march_launch) {
    TY_GLOBAL const ty_march_request* request = arguments->request;
    ty_march_ray ray;
    ty_march_pixel pixel;
    const int32_t x = ty_march_column(arguments, index, arguments->width);
    const int32_t y = ty_march_row(arguments, index, arguments->width);
    ty_march_count(arguments, index, ty_pixel_march(request, &ray, x, y, request->camera.sampled, &pixel));
    ty_march_store(arguments, index, &pixel);
}
