/* Row loop of the residuum, compiled once per instruction set. */
#ifndef TY_METHOD_POP_PUBLISHED_RESIDUUM_KERNEL_H
#define TY_METHOD_POP_PUBLISHED_RESIDUUM_KERNEL_H

#include "base/dispatch.h"

#include <stddef.h>
#include <stdint.h>

/* A row of the residuum: light, and transmittance e^(-sigma_a dx / 2) of half a cell along each axis. Arrays have
 * dark ghost cells around the box. */
typedef struct ty_pop_residuum_row {
    int32_t count;
    ptrdiff_t stride[3]; /* offset to the next cell along each axis */
    const float* half[3];
    const float* from;
    float* to;
    float* accumulated; /* sum of the light that entered */
} ty_pop_residuum_row;

typedef struct ty_pop_residuum_kernels {
    float (*propagate)(const ty_pop_residuum_row* row); /* returns the sum of entering light */
} ty_pop_residuum_kernels;
TY_DECLARE_KERNELS(ty_pop_residuum_kernels);

#endif
