/* Row loop of the residuum; compiled once per instruction set, named by TY_ISA. */
#include "method/pop/published/residuum_kernel.h"

/* Light entering each cell: a sixth of each neighbour's, times the transmittance of half of either cell. */
static float propagate(const ty_pop_residuum_row* row) {
    const ptrdiff_t x = row->stride[0], y = row->stride[1], z = row->stride[2];
    const float *half_x = row->half[0], *half_y = row->half[1], *half_z = row->half[2], *from = row->from;
    float *to = row->to, *accumulated = row->accumulated;
    float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < row->count; ++i) {
        const float along_x = half_x[i] * (half_x[i - x] * from[i - x] + half_x[i + x] * from[i + x]);
        const float along_y = half_y[i] * (half_y[i - y] * from[i - y] + half_y[i + y] * from[i + y]);
        const float along_z = half_z[i] * (half_z[i - z] * from[i - z] + half_z[i + z] * from[i + z]);
        const float in = (along_x + along_y + along_z) * (1.0f / 6.0f);
        to[i] = in;
        accumulated[i] += in;
        sum += in;
    }
    return sum;
}

const ty_pop_residuum_kernels TY_KERNEL_NAME(ty_pop_residuum_kernels) = {.propagate = propagate};
