/* The baker's kernel; built once per instruction set, with TY_ISA naming it. */

#define TY_PATH_GLOSS 0 /* the baker takes glossy surfaces for diffuse ones */
#include "bake/cache/cached.k.h"

#include "base/float_mode.h"
#include "bake/receivers/sample.k.h"

static void begin_receiver(ty_gather* g, const ty_bake_receiver* receiver, ty_bake_sums* sums, float* emitter_cdf) {
    ty_gather_set_receiver(g, receiver);
    g->rays = 0;
    g->sums = sums;
    ty_impulse_begin(g, emitter_cdf);
}

TY_BAKE_KERNEL(TY_KERNEL_NAME(ty_bake_kernel)) {
    const unsigned thread_state = ty_flush_denormals();
    ty_gather g = {.request = request};
    const bool cached = request->cache.light != NULL;
    float emitter_cdf[TY_VIRTUAL_EMITTERS_MAX];
    for (int64_t item = begin; item < end; ++item) {
        ty_bake_sums* sum = &sums[item];
        if (sum->done != 0) continue;
        begin_receiver(&g, &request->receivers[item], sum, emitter_cdf);
        g.light = light + item * (TY_BAKE_LAYERS * 3) * request->terms;
        for (uint32_t i = first; i < first + count; ++i) {
            for (int c = 0; c < 3; ++c) g.sample[c] = 0.0f;
            if (ty_gather_sample(&g, (uint64_t)(request->first + item), i)) sum->blocked += 1;
            for (int c = 0; c < 3; ++c) {
                sum->mean[c] += (double)g.sample[c];
                sum->square[c] += (double)g.sample[c] * (double)g.sample[c];
            }
        }
        if (cached) ty_cached_gather(&g, (uint64_t)(request->first + item), first, count);
        sum->paths += count;
        sum->rays += g.rays;
        sum->count += (int32_t)count;
    }
    ty_restore_denormals(thread_state);
}
