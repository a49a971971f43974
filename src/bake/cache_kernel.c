/* The cache's kernels; built once per instruction set, with TY_ISA naming it. */
#include "bake/cache_walls.k.h"

#include "base/float_mode.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

TY_CACHE_KERNEL(TY_JOIN(ty_cache_kernel_, TY_ISA)) {
    const unsigned thread_state = ty_flush_denormals();
    uint64_t rays = 0;
    for (int64_t i = begin; i < end; ++i) known[request->cells[i]] = ty_cache_fill(request, request->cells[i], &rays);
    ty_restore_denormals(thread_state);
    return rays;
}

TY_CACHE_KERNEL(TY_JOIN(ty_wall_kernel_, TY_ISA)) {
    const unsigned thread_state = ty_flush_denormals();
    ty_gather g = {.request = request->bake};
    (void)known;
    for (int64_t i = begin; i < end; ++i) ty_wall_fill(&g, request, request->cells[i]);
    ty_restore_denormals(thread_state);
    return g.rays;
}
