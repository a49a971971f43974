/* The path tracing kernel with a guide, apart, so that the other one does without its code. */
#define TY_PATH_GUIDED 1
#include "method/path/trace/items.k.h"

TY_PATH_KERNEL(TY_KERNEL_NAME(ty_path_guided_kernel)) {
    return ty_path_sample_items(request, begin, end, first_sample, count, sums, aov_sums);
}
