/* Cells with x and z exchanged, for parallel light along rows, and memory for them. */
#ifndef TY_DIRECT_UNCOLLIDED_TRANSPOSE_H
#define TY_DIRECT_UNCOLLIDED_TRANSPOSE_H

#include <tyndall/base.h>

/* Transposed extinction, then planes, which are zero between sweeps. It is reused by the next sweep through the same
 * extinction. */
typedef struct ty_transpose_scratch {
    float* floats; /* NULL: not allocated yet */
    size_t count;
} ty_transpose_scratch;

void ty_transpose_scratch_free(ty_context* context, ty_transpose_scratch* scratch);

/* Exchanges x and z. size: cells of `from` along x, y and z; adds: to what `to` has. */
void ty_exchange_axes(ty_context* context, const int32_t size[3], const float* from, float* to, bool adds);

#endif
