/* One iteration of propagation for a row of cells; built once per instruction set, with TY_ISA naming it. */
#include "method/lpv/propagate/step.k.h"

/* Prefetches the rows that the next one starts with, for lattices wider than caches hold. */
enum { WIDE = 48 };
TY_INLINE void fetch_next(const ty_lpv_row* row) {
    const ptrdiff_t line = 64 / (ptrdiff_t)sizeof(float);
    for (ptrdiff_t i = 0; i < row->pitch.row; i += line) {
        __builtin_prefetch(row->from + row->pitch.plane + 2 * row->pitch.row + i, 0, 2);
        __builtin_prefetch(row->to + row->pitch.row + i, 1, 2);
        if (row->sum != NULL) __builtin_prefetch(row->sum + row->pitch.row + i, 1, 2);
    }
}

TY_INLINE void step_row(const ty_lpv_row* row, int32_t terms, ty_lpv_lane_sums* sums) {
    ty_lpv_cells block;
    block.row = row;
    block.begin = 0;
    if (row->blocked_links != NULL) ty_lpv_set_transparent(&block, ty_lpv_all_links);
    if (row->count > WIDE) fetch_next(row);
    for (; block.begin < row->count; block.begin += TY_LANES) {
        block.count = row->count - block.begin;
        block.blocked_links = row->blocked_links != NULL ? row->blocked_links[block.begin / TY_LPV_BLOCK] : 0;
        ty_lpv_find_transmission(&block);
        for (int32_t c = 0; c < 3; ++c) ty_lpv_step_cells(&block, c, terms, sums->sums[c]);
        ty_lpv_set_transparent(&block, block.blocked_links);
    }
    for (int32_t c = 0; c < 3; ++c) sums->sums[c][TY_LPV_LEFT][0] += ty_lpv_left_at_ends(row, c, terms);
}

static void step(const ty_lpv_row* row, ty_lpv_lane_sums* sums) {
    if (row->terms == 4)
        step_row(row, 4, sums);
    else
        step_row(row, TY_SH_TERMS, sums);
}

const ty_lpv_kernels TY_KERNEL_NAME(ty_lpv_kernels) = {.step = step};
