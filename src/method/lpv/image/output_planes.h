/* The image's channels while it is being rendered. */
#ifndef TY_METHOD_LPV_OUTPUT_PLANES_H
#define TY_METHOD_LPV_OUTPUT_PLANES_H

#include <tyndall/image.h>

/* Sums over the samples of each pixel; NULL where a channel is not asked for. depth uses index 0 only. */
typedef struct ty_lpv_output_planes {
    ty_context* context;
    ty_image* image;
    int32_t width, height;
    float *color[3], *transmittance[3], *depth[3], *normal[3], *albedo[3], *single[3], *multiple[3];
    float* hits; /* rays of a pixel that hit a surface; NULL: no depth is asked for */
} ty_lpv_output_planes;

/* An image of R, G, B and the channels of `aovs`. Errors: TY_ERROR_MEMORY; ended with ty_lpv_output_planes_free, failed
 * or not, which leaves the image to the caller. */
ty_result ty_lpv_output_planes_create(ty_context* context, int32_t width, int32_t height, uint32_t aovs,
                                      ty_lpv_output_planes* planes);
void ty_lpv_output_planes_free(ty_lpv_output_planes* planes);

/* Divides the sums by the number of samples, normalises normals, and takes depth over the rays that hit a surface. */
void ty_lpv_output_planes_finish(const ty_lpv_output_planes* planes, int32_t samples);

#endif
