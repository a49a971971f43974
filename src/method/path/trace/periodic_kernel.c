/* The path tracing kernel of periodic scenes, apart, so that the other ones do without its code. */
#define TY_PATH_PERIODIC 1
#include "method/path/trace/items.k.h"

TY_PATH_KERNEL(TY_KERNEL_NAME(ty_path_periodic_kernel)) {
    return ty_path_sample_items(request, begin, end, first_sample, count, sums, aov_sums);
}
