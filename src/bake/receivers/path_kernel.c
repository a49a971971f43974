/* The kernel of the baker's reference in scenes with solid dielectrics: paths that refract, and see gloss; built once
 * per instruction set, with TY_ISA naming it. */
#include "bake/receivers/path_sample.k.h"

#include "base/float_mode.h"

TY_BAKE_KERNEL(TY_KERNEL_NAME(ty_bake_path_kernel)) {
    const unsigned thread_state = ty_flush_denormals();
    for (int64_t item = begin; item < end; ++item)
        ty_gather_path_receiver(request, item, first, count, &sums[item],
                                light + item * (TY_BAKE_LAYERS * 3) * request->terms);
    ty_restore_denormals(thread_state);
}
