/* Adjoint of parallel light: derivatives of a weighted sum of its mean fluence in cells by the extinction of each cell
 * and by the strength of the light. It is exact for the tubes of collimated.h, without surfaces. */
#ifndef TY_DIRECT_UNCOLLIDED_COLLIMATED_ADJOINT_H
#define TY_DIRECT_UNCOLLIDED_COLLIMATED_ADJOINT_H

#include "direct/lights/discrete_light.h"
#include "direct/media/grid_medium.h"

/* The loss is the sum over `channels` channels and all cells of weight[c] color[c] T, with T the mean transmittance
 * from one direction through one plane of extinction. */
typedef struct ty_collimated_loss {
    const ty_discrete_light* source; /* a direction; its color is not used */
    const float* extinction;         /* 1/m */
    int32_t channels;                /* 1..3 */
    const float* weight[3];          /* one per cell */
    float color[3];                  /* fluence without media, W m^-2 */
} ty_collimated_loss;

/* Adds the derivatives by extinction to `gradient`, one per cell, and sets strength[c] to the part of the loss that is
 * channel c's, which is its derivative by a factor of the light. Errors: TY_ERROR_MEMORY. */
ty_result ty_collimated_adjoint(const ty_grid_medium* medium, const ty_collimated_loss* loss, float* gradient,
                                double strength[3]);

#endif
