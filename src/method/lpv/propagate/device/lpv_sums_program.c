/* Sums of a step of propagation over the cells of rows, on devices. */
#include "device/entry.k.h"
#include "method/lpv/propagate/device/launch.h"

TY_DEVICE_ENTRY(lpv_sums, ty_lpv_launch) {
    TY_GLOBAL const float* sums = arguments->sums + index * arguments->size[0];
    double total = 0;
    for (int32_t x = 0; x < arguments->size[0]; ++x) total += (double)sums[x];
    arguments->totals[index] = total;
}
