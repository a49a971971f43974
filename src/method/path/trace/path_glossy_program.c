/* The path tracer on devices. */
#include "method/path/trace/device_item.k.h"

TY_DEVICE_ENTRY(path_glossy, ty_path_launch) {
    ty_path_launch_item(arguments, index);
}
