/* Choice of the instruction set. */
#include "base/isa.h"
#include "method/lpv/propagate/kernel.h"

const ty_lpv_kernels* ty_lpv_kernels_best(void) {
#if TY_ISA_X86
    static const ty_lpv_kernels* const kernels[TY_ISA_COUNT] = {&ty_lpv_kernels_v1, &ty_lpv_kernels_v3,
                                                                &ty_lpv_kernels_v4};
    return kernels[ty_best_isa()];
#else
    return &ty_lpv_kernels_v1;
#endif
}
