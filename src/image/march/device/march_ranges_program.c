/* Ranges of depths of the media in columns of froxels, on devices. */
#include "image/march/device/item.k.h"
#include "image/march/froxels.k.h"

TY_DEVICE_ENTRY(march_ranges, ty_march_launch) {
    TY_GLOBAL const ty_march_request* request = arguments->request;
    TY_GLOBAL float* range = arguments->ranges + 2 * (arguments->begin + index);
    range[0] = TY_FLOAT_MAX;
    range[1] = 0.0f;
    ty_froxel_add_column(request, ty_march_column(arguments, index, request->froxels.size[0]),
                         ty_march_row(arguments, index, request->froxels.size[0]), range);
    ty_march_count(arguments, index, 0);
}
