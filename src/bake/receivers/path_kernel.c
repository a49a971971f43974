/* The kernel of the baker's reference in scenes with solid dielectrics: paths that refract, and see gloss; built once
 * per instruction set, with TY_ISA naming it. */
#include "bake/receivers/sample.k.h"

#include "base/float_mode.h"

TY_BAKE_KERNEL(TY_KERNEL_NAME(ty_bake_path_kernel)) {
    const unsigned thread_state = ty_flush_denormals();
    ty_gather g = {.request = request};
    for (int64_t item = begin; item < end; ++item) {
        ty_bake_sums* sum = &sums[item];
        if (sum->done != 0) continue;
        ty_gather_set_receiver(&g, &request->receivers[item]);
        g.rays = 0;
        g.sums = sum;
        g.light = light + item * (TY_BAKE_LAYERS * 3) * request->terms;
        for (uint32_t i = first; i < first + count; ++i) {
            for (int c = 0; c < 3; ++c) g.sample[c] = 0.0f;
            ty_path_begin(&g.path, &request->path, (uint64_t)(request->first + item), i);
            g.path.origin = g.origin;
            g.path.normal = g.normal;
            ty_path_begin_inside(&g.path);
            ty_gather_path(&g);
            for (int c = 0; c < 3; ++c) {
                sum->mean[c] += (double)g.sample[c];
                sum->square[c] += (double)g.sample[c] * (double)g.sample[c];
            }
        }
        sum->paths += count;
        sum->rays += g.rays;
        sum->count += (int32_t)count;
    }
    ty_restore_denormals(thread_state);
}
