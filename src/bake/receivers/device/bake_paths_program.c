/* The baker's reference on devices, which takes glossy surfaces for diffuse ones. */
#define TY_PATH_GLOSS 0
#include "bake/receivers/device/item.k.h"

TY_DEVICE_ENTRY(bake_paths, ty_bake_launch) {
    ty_bake_launch_item(arguments, index);
}
