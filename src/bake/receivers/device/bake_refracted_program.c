/* The baker's reference on devices, in scenes with solid dielectrics. */
#include "bake/receivers/device/item.k.h"

TY_DEVICE_ENTRY(bake_refracted, ty_bake_launch) {
    ty_bake_launch_item(arguments, index);
}
