/* Points of an image at which irradiance outside of the field's box is gathered. */
#ifndef TY_IMAGE_GATHERED_H
#define TY_IMAGE_GATHERED_H

#include "image/march/kernel.h"

/* Fills the points of a row; returns the number of steps. */
#define TY_GATHERED_KERNEL(name) uint64_t name(const ty_march_request* request, int32_t row)
typedef TY_GATHERED_KERNEL((*ty_gathered_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_GATHERED_KERNEL, ty_gathered_kernel);

/* The points of an image, without memory; none (0 columns) where all surfaces are inside of the field's box. */
ty_gathered_view ty_gathered_lay_out(const ty_scene* scene, const ty_march_request* request, int32_t width,
                                     int32_t height);

/* Gathers at all points of an image, if any. *steps: number of steps.
 * Errors: TY_ERROR_MEMORY. Freed with ty_gathered_destroy, also after an error. */
ty_result ty_gathered_create(const ty_scene* scene, ty_march_request* request, int32_t width, int32_t height,
                             uint64_t* steps);
void ty_gathered_destroy(ty_context* context, ty_gathered_view* gathered);

#endif
