#include "base/isa.h"

#include <stdatomic.h>

static _Atomic int forced_isa = TY_ISA_COUNT;

static ty_isa processor_isa(void) {
#if TY_ISA_X86
    __builtin_cpu_init();
    const int v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
    if (v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return TY_ISA_V4;
    if (v3) return TY_ISA_V3;
#endif
    return TY_ISA_V1;
}

ty_isa ty_best_isa(void) {
    const ty_isa best = processor_isa(), forced = (ty_isa)atomic_load(&forced_isa);
    return forced < best ? forced : best;
}

void ty_force_isa(ty_isa isa) {
    atomic_store(&forced_isa, (int)isa);
}

const char* ty_isa_name(ty_isa isa) {
#if TY_ISA_X86
    static const char* const names[TY_ISA_COUNT] = {"x86-64", "x86-64-v3", "x86-64-v4"};
    return names[isa];
#else
    (void)isa;
    return "generic";
#endif
}
