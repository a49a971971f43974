/* Entry points of programs for devices: a function of one index, which a device runs for many at once.
 *
 * TY_DEVICE_ENTRY(name, type) begins the definition of one; its text uses `arguments`, a pointer to a structure `type`
 * in the device's memory, and `index`. In PTX the entry's name is ty_entry_NAME; built for this machine it is a
 * function in ty_program_NAME, which device/host.c calls for blocks of indices. Denormals count as 0 in both. */
#ifndef TY_DEVICE_ENTRY_K_H
#define TY_DEVICE_ENTRY_K_H

#include "base/float_mode.h"
#include "base/kernel.h"
#include "device/program.h"

#if defined(__NVPTX__)
#define TY_DEVICE_ENTRY(name, type)                                                                                    \
    static void name##_index(TY_GLOBAL const type* arguments, int64_t index);                                          \
    void ty_entry_##name(TY_GLOBAL const type* arguments, int64_t count);                                              \
    void ty_entry_##name(TY_GLOBAL const type* arguments, int64_t count) {                                             \
        const int64_t index =                                                                                          \
            (int64_t)__nvvm_read_ptx_sreg_ctaid_x() * __nvvm_read_ptx_sreg_ntid_x() + __nvvm_read_ptx_sreg_tid_x();    \
        if (index < count) name##_index(arguments, index);                                                             \
    }                                                                                                                  \
    static void name##_index(TY_GLOBAL const type* arguments, int64_t index)
#else
#define TY_DEVICE_ENTRY(name, type)                                                                                    \
    static void name##_index(TY_GLOBAL const type* arguments, int64_t index);                                          \
    static void name##_block(const void* arguments, int64_t begin, int64_t end) {                                      \
        const unsigned state = ty_flush_denormals();                                                                   \
        for (int64_t index = begin; index < end; ++index) name##_index(arguments, index);                              \
        ty_restore_denormals(state);                                                                                   \
    }                                                                                                                  \
    extern const ty_ptx ty_ptx_##name;                                                                                 \
    extern const ty_program ty_program_##name;                                                                         \
    const ty_program ty_program_##name = {#name, name##_block, &ty_ptx_##name};                                        \
    static void name##_index(TY_GLOBAL const type* arguments, int64_t index)
#endif

#endif
