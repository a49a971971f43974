/* A step of propagation with three bands on devices. */
#include "method/lpv/propagate/device/strip.k.h"

TY_DEVICE_ENTRY(lpv_three, ty_lpv_launch) {
    ty_lpv_step_strip(arguments, TY_SH_TERMS, index);
}
