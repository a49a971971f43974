/* Smoothing of the points at which irradiance is gathered, on devices. */
#include "image/march/device/item.k.h"

TY_DEVICE_ENTRY(march_smoothed, ty_march_launch) {
    TY_GLOBAL const ty_gathered_view* view = &arguments->request->gathered;
    ty_gathered_smooth(view, ty_march_column(arguments, index, view->columns),
                       ty_march_row(arguments, index, view->columns), &arguments->smoothed[arguments->begin + index]);
    ty_march_count(arguments, index, 0);
}
