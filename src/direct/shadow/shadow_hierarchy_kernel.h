/* Traversal of many lines at once, built once per instruction set: their memory latencies overlap. */
#ifndef TY_DIRECT_SHADOW_SHADOW_HIERARCHY_KERNEL_H
#define TY_DIRECT_SHADOW_SHADOW_HIERARCHY_KERNEL_H

#include "base/dispatch.h"
#include "direct/shadow/shadow_hierarchy.k.h"

typedef struct ty_shadow_kernels {
    /* ty_shadow_traverse for up to TY_SHADOW_RAYS_MAX lines, each with its own list of segments. */
    void (*walk)(const ty_shadow_face* face, const ty_shadow_line* lines, int32_t count, int32_t side, int32_t top,
                 ty_lit_segments* lists);
} ty_shadow_kernels;
TY_DECLARE_KERNELS(ty_shadow_kernels);

#endif
