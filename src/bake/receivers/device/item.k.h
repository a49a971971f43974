/* One receiver on a device, with all that its kernel calls. */
#ifndef TY_BAKE_RECEIVERS_DEVICE_ITEM_K_H
#define TY_BAKE_RECEIVERS_DEVICE_ITEM_K_H

#include "bake/receivers/device/launch.h"
#include "bake/receivers/path_sample.k.h"
#include "device/entry.k.h"
#include "scene/interiors_walk.k.h"
#include "scene/surfaces/bvh_accel.k.h"
#include "scene/surfaces/surface_gloss.k.h"

TY_FN void ty_bake_launch_item(TY_GLOBAL const ty_bake_launch* launch, int64_t index) {
    const int64_t item = launch->begin + index;
    ty_gather_path_receiver(launch->request, item, launch->first, launch->count, launch->sums + item,
                            launch->light + item * (TY_BAKE_LAYERS * 3) * launch->request->terms);
}

#endif
