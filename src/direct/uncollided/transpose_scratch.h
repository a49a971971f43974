/* Memory for transposed cells, for parallel light along rows. */
#ifndef TY_DIRECT_UNCOLLIDED_TRANSPOSE_SCRATCH_H
#define TY_DIRECT_UNCOLLIDED_TRANSPOSE_SCRATCH_H

#include <tyndall/base.h>

/* Transposed extinction, then planes, which are zero between sweeps. It is reused by the next sweep through the same
 * extinction. */
typedef struct ty_transpose_scratch {
    float* floats; /* NULL: not allocated yet */
    size_t count;
} ty_transpose_scratch;

void ty_transpose_scratch_free(ty_context* context, ty_transpose_scratch* scratch);

#endif
