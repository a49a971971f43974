/* Columns of froxels, on devices. */
#include "image/march/device/item.k.h"
#include "image/march/froxels.k.h"

TY_DEVICE_ENTRY(march_columns, ty_march_launch) {
    TY_GLOBAL const ty_march_request* request = arguments->request;
    ty_march_ray ray;
    ty_march_count(arguments, index,
                   ty_froxel_fill(request, &ray, ty_march_column(arguments, index, request->froxels.size[0]),
                                  ty_march_row(arguments, index, request->froxels.size[0])));
}
