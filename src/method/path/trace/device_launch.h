/* Arguments of a launch of the path tracer on a device, and its programs. */
#ifndef TY_METHOD_PATH_TRACE_DEVICE_LAUNCH_H
#define TY_METHOD_PATH_TRACE_DEVICE_LAUNCH_H

#include "device/program.h"
#include "method/path/trace/kernel.h"

/* Samples [first_sample, first_sample + count) of items begin + index, as TY_PATH_KERNEL. All arrays are of the whole
 * run's items, in the device's memory, and so are the arrays that the request names. */
typedef struct ty_path_launch {
    TY_GLOBAL const ty_path_request* request;
    TY_GLOBAL ty_path_sums* sums;
    TY_GLOBAL ty_path_aov_sums* aov_sums; /* NULL: none */
    TY_GLOBAL uint64_t* vertices;         /* of all launches, by item */
    int64_t begin;
    uint32_t first_sample, count;
} ty_path_launch;

/* For scenes whose surfaces are all Lambertian, and for others. */
extern const ty_program ty_program_path_diffuse, ty_program_path_glossy;

#endif
