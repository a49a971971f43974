/* Points of an image at which irradiance is gathered; built once per instruction set, with TY_ISA naming it. */
#include "image/march/gathered.h"

#include "base/float_mode.h"
#include "image/march/pixel.k.h"

TY_GATHERED_KERNEL(TY_KERNEL_NAME(ty_gathered_kernel)) {
    const unsigned state = ty_flush_denormals();
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t i = 0; i < request->gathered.columns; ++i) steps += ty_pixel_gather(request, &ray, i, row);
    ty_restore_denormals(state);
    return steps;
}
