/* Programs for devices, each with one entry point. */
#ifndef TY_DEVICE_PROGRAM_H
#define TY_DEVICE_PROGRAM_H

#include <stddef.h>
#include <stdint.h>

/* A place in a device's memory, as its kernels' pointers have it; 0: none. */
typedef uint64_t ty_address;

/* A program in PTX, deflated (cmake/tyndallDevice.cmake); bytes is NULL in builds without it. */
typedef struct ty_ptx {
    const unsigned char* bytes;
    size_t size, inflated;
} ty_ptx;

/* A program: one entry point, a function of (arguments, index), in the forms that backends run. */
typedef struct ty_program {
    const char* name; /* TY_DEVICE_ENTRY(name, ...) */
    void (*host)(const void* arguments, int64_t begin, int64_t end);
    const ty_ptx* ptx;
} ty_program;

#endif
