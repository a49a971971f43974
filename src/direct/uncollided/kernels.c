/* Dispatch of the row loops by instruction set. */
#include "base/isa.h"
#include "direct/uncollided/kernel.h"

const ty_direct_kernels* ty_direct_kernels_best(void) {
#if TY_ISA_X86
    static const ty_direct_kernels* const kernels[TY_ISA_COUNT] = {&ty_direct_kernels_v1, &ty_direct_kernels_v3,
                                                                   &ty_direct_kernels_v4};
    return kernels[ty_best_isa()];
#else
    return &ty_direct_kernels_v1;
#endif
}
