/* Propagation on the device of a context. */
#ifndef TY_METHOD_LPV_PROPAGATE_DEVICE_DEVICE_H
#define TY_METHOD_LPV_PROPAGATE_DEVICE_DEVICE_H

#include "method/lpv/propagate/propagation.h"

typedef struct ty_lpv_device ty_lpv_device;

/* Places a propagation after the injection of its light; NULL, and TY_OK, where the context has no device. The device
 * is this thread's until ty_lpv_device_destroy. Errors: those of ty_context_device, TY_ERROR_MEMORY. */
ty_result ty_lpv_device_create(ty_lpv_propagation* propagation, ty_lpv_device** out);
void ty_lpv_device_destroy(ty_lpv_device* on);

/* ty_lpv_propagation_step; the first step adds to the sum, and then every other one. */
ty_result ty_lpv_device_step(ty_lpv_device* on, bool adds, ty_lpv_sums* out);
/* Reads the light back into the propagation. */
ty_result ty_lpv_device_finish(ty_lpv_device* on);

#endif
