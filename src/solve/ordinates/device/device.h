/* Sweeps on the device of a context. */
#ifndef TY_SOLVE_ORDINATES_DEVICE_DEVICE_H
#define TY_SOLVE_ORDINATES_DEVICE_DEVICE_H

#include "solve/ordinates/sweep_kernel.h"

/* The memory of a sweep on a device. */
typedef struct ty_sweep_device ty_sweep_device;

/* *out is NULL where the processor is to sweep, because the context has no device. Errors: those of
 * ty_context_device. */
ty_result ty_sweep_device_create(ty_context* context, const ty_sweep_box* box, ty_sweep_device** out);
void ty_sweep_device_destroy(ty_sweep_device* on);
/* As ty_sweep_run, of a box without boundary faces that is whole. Errors: TY_ERROR_MEMORY and others of the device. */
ty_result ty_sweep_device_run(ty_sweep_device* on, const float* emission, float* moments, double* leaving,
                              double* fixups);

#endif
