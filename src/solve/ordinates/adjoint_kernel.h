/* Passes through all cells along the directions of two octants, for the adjoint of a solution. Compiled once per
 * instruction set. */
#ifndef TY_SOLVE_ORDINATES_ADJOINT_KERNEL_H
#define TY_SOLVE_ORDINATES_ADJOINT_KERNEL_H

#include "base/dispatch.h"
#include "solve/ordinates/sweep_kernel.h"

/* A pair of octants as in ty_sweep_block, and a group of lanes. */
typedef struct ty_adjoint_pass {
    int32_t pair, group;
    float* scratch;   /* ty_adjoint_kernels.scratch floats, aligned to 64 bytes */
    float* psi[2];    /* aligned to 64 bytes: mean radiance of each cell and lane in both octants */
    uint16_t* closed; /* out: faces set to zero, as ty_sweep_set_closed takes them; NULL: not kept */
    float* sums;      /* per cell, to which is added; NULL: no sums of a forward pass */
} ty_adjoint_pass;

typedef struct ty_adjoint_kernels {
    int32_t lanes;
    size_t (*scratch)(const ty_sweep_box* box); /* floats */
    /* The solution's own radiance, to psi; adds the part of phi_00 of these directions to the sums. */
    void (*forward)(const ty_sweep_box* box, const float* emission, const ty_adjoint_pass* pass);
    /* The adjoint radiance along the opposite directions, with box->closed; adds the sum of weight times psi times that
     * over the directions, times Y_00, to the sums. */
    void (*multiply)(const ty_sweep_box* box, const float* emission, const ty_adjoint_pass* pass);
} ty_adjoint_kernels;
TY_DECLARE_KERNELS(ty_adjoint_kernels);

#endif
