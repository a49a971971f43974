/* Pixels through which an edge of thick media passes: their outlines, and edges between two of their faces. Media that
 * are opaque within less than a pixel are lit in a strip of one mean free path along such an edge, which a single ray
 * sees over the whole pixel or not at all. */
#ifndef TY_IMAGE_EDGES_H
#define TY_IMAGE_EDGES_H

#include "image/march/kernel.h"

/* Faces of the pixels [-1, width] of row y, into faces[0..]: of the medium that the ray through the center enters
 * first, 0: no thick medium. */
#define TY_EDGES_KERNEL(name)                                                                                          \
    void name(const ty_march_request* request, int32_t y, int32_t width, TY_GLOBAL int32_t* faces)
typedef TY_EDGES_KERNEL((*ty_edges_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_EDGES_KERNEL, ty_edges_kernel);

/* False where pixels at edges get no more rays than others, or all media are thin over the width of a pixel. */
bool ty_edges_may_exist(const ty_march_request* request, int32_t width, int32_t height, int32_t rays);

/* Finds the pixels whose face differs from that of one of the eight around, and gives them `rays` rays. Errors:
 * TY_ERROR_MEMORY. Freed with ty_edges_destroy, also after an error. */
ty_result ty_edges_create(const ty_scene* scene, int32_t width, int32_t height, int32_t rays,
                          ty_march_request* request);
void ty_edges_destroy(ty_context* context, ty_edges_view* edges);

#endif
