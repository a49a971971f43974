/* Derivatives of a loss by the coefficients of media on cells. */
#ifndef TY_DIRECT_MEDIA_MEDIUM_GRADIENT_H
#define TY_DIRECT_MEDIA_MEDIUM_GRADIENT_H

#include "direct/media/grid_medium.h"

/* One number per cell and plane of a ty_grid_medium: of a gray medium one plane, which has the derivative by the value
 * that all channels have in common. */
typedef struct ty_medium_gradient {
    ty_context* context;
    size_t cells;
    int32_t planes;
    float *extinction[3], *scattering[3], *scattering_g[3]; /* by sigma_t, sigma_s and sigma_s g; NULL beyond planes */
} ty_medium_gradient;

/* A gradient of zeros. ty_medium_gradient_free may follow in any case. Errors: TY_ERROR_MEMORY. */
ty_result ty_medium_gradient_make(const ty_grid_medium* medium, ty_medium_gradient* out);
void ty_medium_gradient_free(ty_medium_gradient* gradient);
/* Adds the derivatives by a medium on finer cells of the box, of which `coarse` has the means (ty_grid_medium_resize).
 */
void ty_medium_gradient_refine(const ty_medium_gradient* coarse, const int32_t coarse_size[3], const int32_t size[3],
                               ty_medium_gradient* out);

/* True if the numbers `a` are those of `b` times a factor, to 1e-6 of each: what follows linearly from one follows from
 * the other, times the factor. */
bool ty_is_multiple(const float* a, const float* b, size_t count, float* factor);

#endif
