/* The marcher's kernel of lenses and moving cameras; built once per instruction set, with TY_ISA naming it. */
#include "image/march/kernel.h"

#include "base/float_mode.h"
#include "image/march/pixel.k.h"

TY_MARCH_KERNEL(TY_KERNEL_NAME(ty_march_sampled_kernel)) {
    const unsigned state = ty_flush_denormals();
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t x = begin; x < end; ++x) steps += ty_pixel_march(request, &ray, x, y, 1, &pixels[x - begin]);
    ty_restore_denormals(state);
    return steps;
}
