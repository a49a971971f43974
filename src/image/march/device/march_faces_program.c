/* Faces of thick media at pixels, with a border of one pixel, on devices. */
#include "image/march/device/item.k.h"
#include "image/march/edges.k.h"

TY_DEVICE_ENTRY(march_faces, ty_march_launch) {
    const int32_t columns = arguments->width + 2;
    arguments->faces[arguments->begin + index] =
        ty_edges_face_of_pixel(arguments->request, ty_march_column(arguments, index, columns) - 1,
                               ty_march_row(arguments, index, columns) - 1);
    ty_march_count(arguments, index, 0);
}
