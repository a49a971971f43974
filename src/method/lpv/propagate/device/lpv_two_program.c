/* A step of propagation with two bands on devices. */
#include "method/lpv/propagate/device/strip.k.h"

TY_DEVICE_ENTRY(lpv_two, ty_lpv_launch) {
    ty_lpv_step_strip(arguments, 4, index);
}
