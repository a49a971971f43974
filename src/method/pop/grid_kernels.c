/* Run-time choice of the instruction set for the grid loops. */
#include "base/isa.h"
#include "method/pop/grid_kernel.h"

const ty_pop_grid_kernels* ty_pop_grid_kernels_best(void) {
#if TY_ISA_X86
    static const ty_pop_grid_kernels* const kernels[TY_ISA_COUNT] = {&ty_pop_grid_kernels_v1, &ty_pop_grid_kernels_v3,
                                                                     &ty_pop_grid_kernels_v4};
    return kernels[ty_best_isa()];
#else
    return &ty_pop_grid_kernels_v1;
#endif
}
