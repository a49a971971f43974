/* Points at which irradiance is gathered, on devices. */
#include "image/march/device/item.k.h"

TY_DEVICE_ENTRY(march_gathered, ty_march_launch) {
    TY_GLOBAL const ty_march_request* request = arguments->request;
    ty_march_ray ray;
    const int32_t column = ty_march_column(arguments, index, request->gathered.columns);
    const int32_t row = ty_march_row(arguments, index, request->gathered.columns);
    ty_march_count(arguments, index, ty_pixel_gather(request, &ray, column, row));
}
