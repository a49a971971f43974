/* One item of the path tracer on a device, with all that its kernel calls. */
#ifndef TY_METHOD_PATH_TRACE_DEVICE_ITEM_K_H
#define TY_METHOD_PATH_TRACE_DEVICE_ITEM_K_H

#include "device/entry.k.h"
#include "method/path/trace/device_launch.h"
#include "method/path/trace/items.k.h"
#include "scene/interiors_walk.k.h"
#include "scene/surfaces/bvh_accel.k.h"
#include "scene/surfaces/surface_gloss.k.h"

/* Begins a sample of an item, as ty_path_sample_items. */
TY_FN void ty_path_launch_begin(TY_GLOBAL const ty_path_launch* launch, int64_t item, uint32_t sample, ty_path* path) {
    TY_GLOBAL const ty_path_request* request = launch->request;
    const uint64_t number = random_item(request, item);
    ty_path_begin(path, request, number, sample);
    start(path, request, item);
    if (launch->aov_sums != NULL && request->first_hit != 0)
        add_first_hit(path, number, sample, launch->aov_sums + item);
}

/* All samples of an item in one loop over vertices: threads that run in step would otherwise wait in each sample for
 * the one whose path is longest. */
TY_FN void ty_path_launch_item(TY_GLOBAL const ty_path_launch* launch, int64_t index) {
    const int64_t item = launch->begin + index;
    const uint32_t last = launch->first_sample + launch->count - 1;
    uint32_t sample = launch->first_sample, vertices = 0;
    ty_path path;
    ty_path_launch_begin(launch, item, sample, &path);
    for (;;) {
        if (ty_path_step(&path, &vertices)) continue;
        add_sample(&path, launch->sums + item, launch->aov_sums != NULL ? launch->aov_sums + item : NULL);
        if (sample == last) break;
        ty_path_launch_begin(launch, item, ++sample, &path);
    }
    launch->vertices[item] += vertices;
}

#endif
