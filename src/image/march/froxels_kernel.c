/* Froxels of a view and its pixels; built once per instruction set, with TY_ISA naming it. */
#include "image/march/froxels.h"

#include "base/float_mode.h"
#include "image/march/froxels.k.h"

static void add_range(const ty_march_request* request, int32_t row, float range[2]) {
    for (int32_t column = 0; column < request->froxels.size[0]; ++column)
        ty_froxel_add_column(request, column, row, range);
}

static uint64_t fill(const ty_march_request* request, int32_t row) {
    const unsigned state = ty_flush_denormals();
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t column = 0; column < request->froxels.size[0]; ++column)
        steps += ty_froxel_fill(request, &ray, column, row);
    ty_restore_denormals(state);
    return steps;
}

static TY_MARCH_KERNEL(look_up) {
    const unsigned state = ty_flush_denormals();
    for (int32_t x = begin; x < end; ++x) ty_froxel_look_up(request, x, y, &pixels[x - begin]);
    ty_restore_denormals(state);
    return 0;
}

const ty_froxel_kernels TY_KERNEL_NAME(ty_froxel_kernels) = {.add_range = add_range, .fill = fill, .look_up = look_up};
