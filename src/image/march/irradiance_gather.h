/* The kernel that gathers light of media at a cache's points. */
#ifndef TY_IMAGE_IRRADIANCE_GATHER_H
#define TY_IMAGE_IRRADIANCE_GATHER_H

#include "image/march/irradiance_points.h"
#include "image/march/kernel.h"

/* Irradiance of the media on a point, W m^-2. */
#define TY_IRRADIANCE_KERNEL(name)                                                                                     \
    void name(const ty_march_request* request, const ty_irradiance_point* point, float irradiance[3])
typedef TY_IRRADIANCE_KERNEL((*ty_irradiance_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_IRRADIANCE_KERNEL, ty_irradiance_kernel);

#endif
