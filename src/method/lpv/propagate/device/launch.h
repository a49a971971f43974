/* Arguments of the programs of propagation on a device. */
#ifndef TY_METHOD_LPV_PROPAGATE_DEVICE_LAUNCH_H
#define TY_METHOD_LPV_PROPAGATE_DEVICE_LAUNCH_H

#include "device/program.h"
#include "method/lpv/propagate/kernel.h"

/* Rows that a thread steps, one cell and channel of each: it keeps their sums. */
enum { TY_LPV_STRIP = 4 };

/* Threads of a step: x fastest, then strips, z and channels. */
typedef struct ty_lpv_launch {
    int32_t size[3];                  /* of the lattice, cells */
    int32_t strips;                   /* of a slab */
    TY_GLOBAL const ty_lpv_row* rows; /* of all slabs, y fastest */
    TY_GLOBAL float* sums;            /* by TY_LPV_ARRIVED ..., and by thread */
    TY_GLOBAL double* totals;         /* of these over x: threads of lpv_sums */
} ty_lpv_launch;

/* A step with two bands, or with three; the sums of strips. */
extern const ty_program ty_program_lpv_two, ty_program_lpv_three, ty_program_lpv_sums;

#endif
