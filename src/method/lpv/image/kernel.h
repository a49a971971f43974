/* The image kernels, built once per instruction set. */
#ifndef TY_METHOD_LPV_IMAGE_KERNEL_H
#define TY_METHOD_LPV_IMAGE_KERNEL_H

#include "base/dispatch.h"
#include "method/lpv/image/ray_march.k.h"
#include "method/lpv/image/upsample.k.h"

/* A ray through the media. */
typedef struct ty_media_ray {
    ty_vec origin, direction; /* unit */
    float far;                /* m, TY_FLOAT_MAX at most */
    float offset;             /* end of its first step, (0, 1] of a step */
} ty_media_ray;

/* A surface point and, as the result, its irradiance. */
typedef struct ty_irradiance_query {
    ty_vec point, normal;
    float irradiance[3];
} ty_irradiance_query;

typedef struct ty_lpv_image_kernels {
    void (*ray_march)(const ty_ray_march_request* request, const ty_media_ray* rays, int32_t count,
                      ty_ray_march_result* out);
    /* Upsampled media samples of the pixels of a row from (x, y) on, at the given distances; contrast: as in
     * ty_lpv_upsample_row. */
    void (*upsample)(const ty_lpv_upsample* from, int32_t x, int32_t y, int32_t count, const float* distance,
                     ty_lpv_media_radiance* out, float* contrast);
    void (*irradiance)(const ty_packed_lattices* lattices, ty_irradiance_query* places, int32_t count);
} ty_lpv_image_kernels;
TY_DECLARE_KERNELS(ty_lpv_image_kernels);

#endif
