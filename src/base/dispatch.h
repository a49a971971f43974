/* Choice among the builds of one kernel. A kernel file is compiled once per instruction set, each time with TY_ISA
 * defined as v1, v3 or v4 (cmake/tyndallKernels.cmake), and names its exports with TY_KERNEL_NAME. */
#ifndef TY_BASE_DISPATCH_H
#define TY_BASE_DISPATCH_H

#include "base/isa.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)
/* The name of a kernel's table or function in the build at hand: name_v1, name_v3 or name_v4. */
#define TY_KERNEL_NAME(name) TY_JOIN(name##_, TY_ISA)

/* Declares all builds of a table of kernels; the table is named like its type. */
#define TY_DECLARE_KERNELS(type) extern const type type##_v1, type##_v3, type##_v4
/* Declares all builds of a kernel function; prototype(name) is its prototype. */
#define TY_DECLARE_KERNEL_FUNCTION(prototype, name)                                                                    \
    prototype(name##_v1);                                                                                              \
    prototype(name##_v3);                                                                                              \
    prototype(name##_v4)

/* A pointer to the build for ty_best_isa(), of a table or of a function. */
#if TY_ISA_X86
#define TY_BEST_KERNELS(name) (((__typeof__(name##_v1)* const[]){&name##_v1, &name##_v3, &name##_v4})[ty_best_isa()])
#else
#define TY_BEST_KERNELS(name) (&name##_v1)
#endif

#endif
