/* Sampling of a run's items on a device. */
#ifndef TY_PATH_DEVICE_H
#define TY_PATH_DEVICE_H

#include "device/device.h"
#include "method/path/driver.h"

typedef struct ty_path_device ty_path_device;

/* Takes the context's device for a run, whose items are as they begin or were resumed: *out is NULL where the processor
 * is to trace it, because there is no device, or the run has a guide or light in interiors. odd: the request of odd
 * samples, of a run with halves. Errors: those of ty_context_device and ty_scene_pack. */
ty_result ty_path_device_create(ty_path_run* run, const ty_path_request* odd, ty_path_device** out);
void ty_path_device_destroy(ty_path_device* on);

/* The kind of the device, for ty_path_stats.isa. */
const char* ty_path_device_kind(const ty_path_device* on);

/* Adds samples [first, first + count) of items [begin, end), by the odd request if `odd`, and waits for them. */
ty_result ty_path_device_trace(ty_path_device* on, bool odd, int64_t begin, int64_t end, uint32_t first,
                               uint32_t count);
/* Sums of all items after all samples so far, valid until the next call; aov_sums is NULL without those. *vertices: of
 * all samples. */
ty_result ty_path_device_read(ty_path_device* on, const ty_path_sums** sums, const ty_path_aov_sums** aov_sums,
                              uint64_t* vertices);

#endif
