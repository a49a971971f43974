/* Arguments of the baker's launches on a device, and its programs. */
#ifndef TY_BAKE_RECEIVERS_DEVICE_LAUNCH_H
#define TY_BAKE_RECEIVERS_DEVICE_LAUNCH_H

#include "bake/gather/request.h"
#include "device/program.h"

/* Samples [first, first + count) of receivers begin + index. All arrays are of all receivers, in the device's memory,
 * and so are those that the request names. */
typedef struct ty_bake_launch {
    TY_GLOBAL const ty_bake_request* request;
    TY_GLOBAL ty_bake_sums* sums;
    TY_GLOBAL double* light;
    int64_t begin;
    uint32_t first, count;
} ty_bake_launch;

/* Paths that take glossy surfaces for diffuse ones, and paths that refract at dielectrics. */
extern const ty_program ty_program_bake_paths, ty_program_bake_refracted;

#endif
