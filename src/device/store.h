/* Memory of a device that outlives the arrays in it: a device that keeps (ty_device_keep) copies no array a second time
 * while its contents stay, and allocates none of a size that it has to spare. Other devices give back at once. */
#ifndef TY_DEVICE_STORE_H
#define TY_DEVICE_STORE_H

#include "device/device.h"

/* Memory for `bytes` > 0 that one user alone has, with undefined contents. Errors: those of alloc; idle memory goes
 * first. */
ty_result ty_device_store_alloc(ty_device* device, size_t bytes, ty_address* out);
/* Memory with a copy of `from`, which all users of equal contents share and none changes. origin: NULL for contents
 * that are compared each time. */
ty_result ty_device_store_copy(ty_device* device, const void* from, size_t bytes, const ty_device_origin* origin,
                               ty_address* out);
void ty_device_store_release(ty_device* device, ty_address address);
/* Frees what has had no user since ty_device.keep calls. */
void ty_device_store_end_use(ty_device* device);
/* Frees everything. */
void ty_device_store_close(ty_device* device);

#endif
