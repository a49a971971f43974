/* TY_SCREEN_SCATTER on a device. */
#ifndef TY_METHOD_SCREEN_DEVICE_DEVICE_H
#define TY_METHOD_SCREEN_DEVICE_DEVICE_H

#include "device/device.h"
#include "method/screen/job.h"

/* As ty_screen_scatter; statistics name the kind of the device. Steps include copies to and from it. Errors:
 * TY_ERROR_MEMORY, here or on the device. */
ty_result ty_screen_scatter_on_device(ty_screen_job* job, ty_device* device);

#endif
