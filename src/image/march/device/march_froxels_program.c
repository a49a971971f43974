/* Pixels by froxels, on devices. */
#include "image/march/device/item.k.h"
#include "image/march/froxels.k.h"

TY_DEVICE_ENTRY(march_froxels, ty_march_launch) {
    ty_march_pixel pixel;
    ty_froxel_look_up(arguments->request, ty_march_column(arguments, index, arguments->width),
                      ty_march_row(arguments, index, arguments->width), &pixel);
    ty_march_store(arguments, index, &pixel);
    ty_march_count(arguments, index, 0);
}
