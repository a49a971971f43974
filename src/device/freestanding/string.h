/* The part of string.h that kernels use, by the compiler's own functions. */
#ifndef TY_DEVICE_FREESTANDING_STRING_H
#define TY_DEVICE_FREESTANDING_STRING_H

#include <stddef.h>

#define memcpy __builtin_memcpy
#define memset __builtin_memset

#endif
