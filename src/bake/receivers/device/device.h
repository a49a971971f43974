/* Sampling of receivers on the device of a context. */
#ifndef TY_BAKE_RECEIVERS_DEVICE_DEVICE_H
#define TY_BAKE_RECEIVERS_DEVICE_DEVICE_H

#include "bake/gather/run.h"

/* The memory of a run on a device. */
typedef struct ty_bake_device ty_bake_device;

/* *out is NULL where the processor is to sample: there is no device, the method is not TY_BAKE_PATH, or media in
 * dielectrics are solved. Errors: those of ty_context_device and ty_scene_pack. */
ty_result ty_bake_device_create(const ty_bake_run* run, ty_bake_device** out);
void ty_bake_device_destroy(ty_bake_device* on);
/* Adds samples [first, first + count) of receivers [begin, end). */
ty_result ty_bake_device_sample(ty_bake_device* on, int64_t begin, int64_t end, uint32_t first, uint32_t count);
/* Brings the run's sums and light up to date. */
ty_result ty_bake_device_read(ty_bake_device* on);
/* Tells the device which receivers are done, by the run's sums. */
ty_result ty_bake_device_write_done(ty_bake_device* on);

#endif
