/* Instruction set selection for kernels. */
#ifndef TY_BASE_ISA_H
#define TY_BASE_ISA_H

typedef enum ty_isa { TY_ISA_V1 = 0, TY_ISA_V3 = 1, TY_ISA_V4 = 2, TY_ISA_COUNT = 3 } ty_isa;

/* Best instruction set supported by the processor and this build and permitted by ty_force_isa. */
ty_isa ty_best_isa(void);
/* For tests: from now on ty_best_isa gives this instruction set, or the processor's best if that is less;
 * TY_ISA_COUNT ends it. */
void ty_force_isa(ty_isa isa);
/* "x86-64", "x86-64-v3", "x86-64-v4", or "generic" on other machines. */
const char* ty_isa_name(ty_isa isa);

#endif
