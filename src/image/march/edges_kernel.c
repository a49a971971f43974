/* Faces of thick media that the rays of pixels enter; built once per instruction set, with TY_ISA naming it. */
#include "image/march/edges.h"

#include "image/march/edges.k.h"

TY_EDGES_KERNEL(TY_KERNEL_NAME(ty_edges_kernel)) {
    for (int32_t x = -1; x <= width; ++x, ++faces) *faces = ty_edges_face_of_pixel(request, x, y);
}
