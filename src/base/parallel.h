/* Parallel loops of a context. */
#ifndef TY_BASE_PARALLEL_H
#define TY_BASE_PARALLEL_H

#include <tyndall/base.h>

/* ty_parallel_for with denormals off (base/float_mode.h); without a context in the calling thread alone. */
void ty_parallel_flushed(ty_context* context, int64_t count, ty_parallel_fn body, void* user);

#endif
