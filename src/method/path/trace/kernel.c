/* Path tracing kernel; compiled once per instruction set, named by TY_ISA. */
#include "method/path/trace/items.k.h"

TY_PATH_KERNEL(TY_KERNEL_NAME(ty_path_kernel)) {
    return ty_path_sample_items(request, begin, end, first_sample, count, sums, aov_sums);
}
