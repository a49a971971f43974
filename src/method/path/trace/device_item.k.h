/* One item of the path tracer on a device, with all that its kernel calls. */
#ifndef TY_METHOD_PATH_TRACE_DEVICE_ITEM_K_H
#define TY_METHOD_PATH_TRACE_DEVICE_ITEM_K_H

#define TY_PATH_FLUXES 0 /* the processor traces those of columns */

#include "device/entry.k.h"
#include "method/path/trace/device_launch.h"
#include "method/path/trace/items.k.h"
#include "scene/interiors_walk.k.h"
#include "scene/surfaces/bvh_accel.k.h"
#include "scene/surfaces/surface_gloss.k.h"

TY_FN void ty_path_launch_item(TY_GLOBAL const ty_path_launch* launch, int64_t index) {
    const int64_t item = launch->begin + index;
    launch->vertices[item] +=
        ty_path_sample_items(launch->request, item, item + 1, launch->first_sample, launch->count, launch->sums + item,
                             launch->aov_sums != NULL ? launch->aov_sums + item : NULL);
}

#endif
