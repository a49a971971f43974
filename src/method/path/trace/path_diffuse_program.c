/* The path tracer on devices, without gloss: far less code for scenes that have none. */
#define TY_PATH_GLOSS 0
#include "method/path/trace/device_item.k.h"

TY_DEVICE_ENTRY(path_diffuse, ty_path_launch) {
    ty_path_launch_item(arguments, index);
}
