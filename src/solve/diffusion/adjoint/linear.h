/* Linear diffusion without a limiter on a box of cells for a sequence of sources: its coefficients are prepared once.
 */
#ifndef TY_SOLVE_DIFFUSION_ADJOINT_LINEAR_H
#define TY_SOLVE_DIFFUSION_ADJOINT_LINEAR_H

#include "solve/diffusion/diffusion.h"

typedef struct ty_linear_diffusion ty_linear_diffusion;

/* Uses size, cell, extinction, absorption, min_extinction and boundaries (without incident flux) of the def, whose
 * planes are not needed afterwards. Errors: TY_ERROR_MEMORY. */
ty_result ty_linear_diffusion_create(ty_context* context, const ty_diffusion_def* def, ty_linear_diffusion** out);
void ty_linear_diffusion_destroy(ty_linear_diffusion* linear);
/* Solves for the fluence of a source of any sign until the rms residual is reduced by about `reduction`, or for at most
 * `cycles` multigrid cycles, whose number it returns. */
int32_t ty_linear_diffusion_solve(ty_linear_diffusion* linear, const float* source, double reduction, int32_t cycles,
                                  double* fluence);

#endif
