/* Pixels at edges of thick media, on devices. */
#include "image/march/device/item.k.h"
#include "image/march/edges.k.h"

TY_DEVICE_ENTRY(march_edges, ty_march_launch) {
    arguments->request->edges.marked[arguments->begin + index] =
        ty_edges_are_at(arguments->faces, arguments->width, ty_march_column(arguments, index, arguments->width),
                        ty_march_row(arguments, index, arguments->width));
    ty_march_count(arguments, index, 0);
}
