/* Many straight ways across a face of a map at once, built once per instruction set: what one after another waits for
 * is waited for together. */
#ifndef TY_DIRECT_LIT_KERNEL_H
#define TY_DIRECT_LIT_KERNEL_H

#include "direct/shadow/lit.k.h"

typedef struct ty_lit_kernels {
    /* As ty_lit_walk for up to TY_LIT_LINES lines, each with its run. */
    void (*walk)(const ty_lit_face* face, const ty_lit_line* lines, int32_t count, int32_t side, int32_t top,
                 ty_lit_run* runs);
} ty_lit_kernels;

extern const ty_lit_kernels ty_lit_kernels_v1;
extern const ty_lit_kernels ty_lit_kernels_v3, ty_lit_kernels_v4;

#endif
