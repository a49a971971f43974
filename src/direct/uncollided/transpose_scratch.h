/* Where cells are turned over for beams along rows. */
#ifndef TY_DIRECT_UNCOLLIDED_TRANSPOSE_SCRATCH_H
#define TY_DIRECT_UNCOLLIDED_TRANSPOSE_SCRATCH_H

#include <tyndall/base.h>

/* Extinction, then planes, which are zeros between passes. Kept from one pass through an extinction to the next through
 * the same, it is not turned again. */
typedef struct ty_transpose_scratch {
    float* floats; /* NULL: there is none yet */
    size_t count;
} ty_transpose_scratch;

void ty_transpose_scratch_free(ty_context* context, ty_transpose_scratch* room);

#endif
