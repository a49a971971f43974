/* One strip of a step of propagation on a device. */
#ifndef TY_METHOD_LPV_PROPAGATE_DEVICE_STRIP_K_H
#define TY_METHOD_LPV_PROPAGATE_DEVICE_STRIP_K_H

#include "device/entry.k.h"
#include "method/lpv/propagate/device/launch.h"
#include "method/lpv/propagate/step.k.h"

TY_INLINE void ty_lpv_step_strip(TY_GLOBAL const ty_lpv_launch* launch, int32_t terms, int64_t index) {
    TY_GLOBAL const int32_t* size = launch->size;
    const int64_t strip = index / size[0], slab = strip / launch->strips;
    const int32_t x = (int32_t)(index % size[0]), z = (int32_t)(slab % size[2]), channel = (int32_t)(slab / size[2]);
    const int32_t begin = (int32_t)(strip % launch->strips) * TY_LPV_STRIP;
    const int32_t end = begin + TY_LPV_STRIP < size[1] ? begin + TY_LPV_STRIP : size[1];
    float sums[TY_LPV_SUMS][TY_LPV_BLOCK];
    TY_UNROLL
    for (int32_t i = 0; i < TY_LPV_SUMS; ++i) sums[i][0] = 0.0f;
    for (int32_t y = begin; y < end; ++y) {
        TY_GLOBAL const ty_lpv_row* row = &launch->rows[(int64_t)z * size[1] + y];
        ty_lpv_cells cells;
        cells.row = row;
        cells.begin = x;
        cells.count = row->count - x;
        cells.blocked_links = row->blocked_links != NULL ? row->blocked_links[x / TY_LPV_BLOCK] : 0;
        if (cells.blocked_links != 0) ty_lpv_set_transparent(&cells, ty_lpv_all_links);
        ty_lpv_find_transmission(&cells);
        ty_lpv_step_cells(&cells, channel, terms, sums);
        if (x == 0) sums[TY_LPV_LEFT][0] += ty_lpv_left_at_ends(row, channel, terms);
    }
    const int64_t threads = (int64_t)3 * size[2] * launch->strips * size[0];
    TY_UNROLL
    for (int32_t i = 0; i < TY_LPV_SUMS; ++i) launch->sums[i * threads + index] = sums[i][0];
}

#endif
