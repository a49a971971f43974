/* The cache's kernels; built once per instruction set, with TY_ISA naming it. */

#define TY_PATH_GLOSS 0 /* the baker takes glossy surfaces for diffuse ones */
#include "bake/cache/surfels.k.h"

#include "base/float_mode.h"

TY_CACHE_KERNEL(TY_KERNEL_NAME(ty_cache_kernel)) {
    const unsigned thread_state = ty_flush_denormals();
    uint64_t rays = 0;
    for (int64_t i = begin; i < end; ++i) flags[request->cells[i]] = ty_cache_fill(request, request->cells[i], &rays);
    ty_restore_denormals(thread_state);
    return rays;
}

TY_CACHE_KERNEL(TY_KERNEL_NAME(ty_surfel_kernel)) {
    const unsigned thread_state = ty_flush_denormals();
    ty_gather g = {.request = request->bake};
    (void)flags;
    for (int64_t i = begin; i < end; ++i) ty_surfel_fill(&g, request, request->cells[i]);
    ty_restore_denormals(thread_state);
    return g.rays;
}
