/* One iteration of propagation for a row of cells; built once per instruction set, with TY_ISA naming it. */
#include "method/lpv/propagate/kernel.h"

#include "base/simd.h"

#include <stdlib.h>

/* All links: their directions and indices. */
#define EACH_LINK(LINK)                                                                                                \
    LINK(-1, -1, -1, 0)                                                                                                \
    LINK(0, -1, -1, 1)                                                                                                 \
    LINK(1, -1, -1, 2)                                                                                                 \
    LINK(-1, 0, -1, 3)                                                                                                 \
    LINK(0, 0, -1, 4)                                                                                                  \
    LINK(1, 0, -1, 5)                                                                                                  \
    LINK(-1, 1, -1, 6)                                                                                                 \
    LINK(0, 1, -1, 7)                                                                                                  \
    LINK(1, 1, -1, 8)                                                                                                  \
    LINK(-1, -1, 0, 9)                                                                                                 \
    LINK(0, -1, 0, 10)                                                                                                 \
    LINK(1, -1, 0, 11)                                                                                                 \
    LINK(-1, 0, 0, 12)                                                                                                 \
    LINK(1, 0, 0, 25)                                                                                                  \
    LINK(-1, 1, 0, 24)                                                                                                 \
    LINK(0, 1, 0, 23)                                                                                                  \
    LINK(1, 1, 0, 22)                                                                                                  \
    LINK(-1, -1, 1, 21)                                                                                                \
    LINK(0, -1, 1, 20)                                                                                                 \
    LINK(1, -1, 1, 19)                                                                                                 \
    LINK(-1, 0, 1, 18)                                                                                                 \
    LINK(0, 0, 1, 17)                                                                                                  \
    LINK(1, 0, 1, 16)                                                                                                  \
    LINK(-1, 1, 1, 15)                                                                                                 \
    LINK(0, 1, 1, 14)                                                                                                  \
    LINK(1, 1, 1, 13)

/* Up to TY_LANES cells of a row and the transmission of the links into them: 1 where blocked_links has no bit. */
typedef struct cell_block {
    const ty_lpv_row* row;
    int32_t begin, count;
    uint32_t blocked_links; /* bits of the blocked links */
    _Alignas(TY_LANE_BYTES) float transmission[TY_LPV_LINKS][TY_LANES];
} cell_block;

/* Zeroes lanes past the row's end. */
TY_INLINE ty_lanes within(ty_lanes value, int32_t count) {
    if (count >= TY_LANES) return value;
    for (int i = 0; i < TY_LANES; ++i)
        if (i >= count) value[i] = 0.0f;
    return value;
}

/* value + step * term for a constant step of -1, 0 or 1. */
TY_INLINE ty_lanes with(ty_lanes value, int32_t step, ty_lanes term) {
    return step == 0 ? value : step > 0 ? value + term : value - term;
}

/* ---- two bands ---- */

/* <L | G_j> of one cell and link. `at`: its first term. */
TY_INLINE ty_lanes along_two(const float* at, ptrdiff_t term, const ty_lpv_link_functions* link_functions, int32_t dx,
                             int32_t dy, int32_t dz) {
    const int32_t kind = abs(dx) + abs(dy) + abs(dz) - 1;
    const float band1 = link_functions->band1[kind];
    ty_lanes value = link_functions->band0[kind] * ty_lanes_load(at);
    if (dy != 0) value = with(value, dy, band1 * ty_lanes_load(at + term));
    if (dz != 0) value = with(value, dz, band1 * ty_lanes_load(at + 2 * term));
    if (dx != 0) value = with(value, dx, band1 * ty_lanes_load(at + 3 * term));
    return value;
}

TY_INLINE void add_two(ty_lanes sum[4], ty_lanes value, float band0, float band1, int32_t dx, int32_t dy, int32_t dz) {
    sum[0] += band0 * value;
    sum[1] = with(sum[1], dy, band1 * value);
    sum[2] = with(sum[2], dz, band1 * value);
    sum[3] = with(sum[3], dx, band1 * value);
}

/* Eq. 3 (Billeter 2012): the sum over j of dL_j = (1 - b_j) <L' | G_j> G_j, where L' is the light of the neighbour with
 * the scattering operator already applied (propagate/transfer.c), and 1 - b_j is the transmission. */
TY_INLINE void gather_two(const cell_block* block, const float* at, bool blocked_links, ty_lanes sum[4]) {
    const ty_lpv_row* row = block->row;
    const ty_lpv_link_functions* link_functions = row->link_functions;
    const ptrdiff_t term = row->pitch.term, to_row = row->pitch.row, to_plane = row->pitch.plane;
#define LINK(dx, dy, dz, k)                                                                                            \
    {                                                                                                                  \
        const int32_t kind = abs(dx) + abs(dy) + abs(dz) - 1;                                                          \
        const float* source = at - (dx) - (dy)*to_row - (dz)*to_plane;                                                 \
        ty_lanes value = along_two(source, term, link_functions, dx, dy, dz);                                          \
        if (blocked_links) value *= ty_lanes_load(block->transmission[k]);                                             \
        add_two(sum, value, link_functions->band0[kind], link_functions->band1[kind], dx, dy, dz);                     \
    }
    EACH_LINK(LINK)
#undef LINK
}

/* ---- three bands ---- */

/* Eq. 3 (Billeter 2012), as gather_two. */
TY_INLINE void gather_three(const cell_block* block, const float* at, bool blocked_links, ty_lanes sum[TY_SH_TERMS]) {
    const ty_lpv_row* row = block->row;
    const ptrdiff_t term = row->pitch.term, to_row = row->pitch.row, to_plane = row->pitch.plane;
#define LINK(dx, dy, dz, k)                                                                                            \
    {                                                                                                                  \
        const float* source = at - (dx) - (dy)*to_row - (dz)*to_plane;                                                 \
        const float* transfer_G = row->link_functions->G[k];                                                           \
        ty_lanes value = transfer_G[0] * ty_lanes_load(source);                                                        \
        for (int32_t t = 1; t < TY_SH_TERMS; ++t) value += transfer_G[t] * ty_lanes_load(source + t * term);           \
        if (blocked_links) value *= ty_lanes_load(block->transmission[k]);                                             \
        for (int32_t t = 0; t < TY_SH_TERMS; ++t) sum[t] += transfer_G[t] * value;                                     \
    }
    EACH_LINK(LINK)
#undef LINK
}

/* ---- surfaces ---- */

static const uint32_t all_links = (1u << TY_LPV_LINKS) - 1;

/* Removes and returns the next link of a set. */
TY_INLINE int32_t take_link(uint32_t* links) {
    const int32_t k = __builtin_ctz(*links);
    *links &= *links - 1;
    return k;
}

/* Full transmission of all links of a set: the state that find_transmission starts from. */
TY_INLINE void set_all_transparent(cell_block* block, uint32_t links) {
    while (links != 0) {
        const int32_t k = take_link(&links);
        for (int32_t i = 0; i < TY_LANES; ++i) block->transmission[k][i] = 1.0f;
    }
}

/* Transmission of the links into the block, 0..1. */
TY_INLINE void find_transmission(cell_block* block) {
    const size_t first = block->row->first + (size_t)block->begin;
    for (uint32_t links = block->blocked_links; links != 0;) {
        const int32_t k = take_link(&links);
        const uint8_t* from = block->row->transmission[k] + first;
        float* transmission = block->transmission[k];
        const int32_t count = block->count < TY_LANES
                                  ? block->count
                                  : TY_LANES; /* a count that GCC could prove would make it unroll into scalars */
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) transmission[i] = (float)from[i] * (1.0f / 255.0f);
    }
}

/* Light that blockers stop on its way out, as lobes back into the cell. Returns the part that would have left the
 * lattice. */
TY_INLINE ty_lanes stop(const cell_block* block, const float* at, int32_t terms, ty_lanes* lobes) {
    const ty_lpv_row* row = block->row;
    const int32_t last = row->count - 1 - block->begin;
    const bool begins = block->begin == 0, ends = row->count > 1 && last < TY_LANES;
    ty_lanes own[TY_SH_TERMS], at_border = {0};
    for (int32_t t = 0; t < terms; ++t) own[t] = ty_lanes_load(at + t * row->pitch.term);
    for (uint32_t links = block->blocked_links; links != 0;) {
        const int32_t k = take_link(&links);
        const float* transfer_G =
            row->link_functions->G[k < TY_LPV_HALF_LINKS ? k + TY_LPV_HALF_LINKS : k - TY_LPV_HALF_LINKS];
        const float* lobe = row->link_functions->lobes[k];
        ty_lanes leaving = transfer_G[0] * own[0];
        for (int32_t t = 1; t < terms; ++t) leaving += transfer_G[t] * own[t];
        const ty_lanes stopped = (1.0f - ty_lanes_load(block->transmission[k])) * (transfer_G[0] * leaving);
        lobes[0] += stopped;
        for (int32_t t = 1; t < terms; ++t) lobes[t] += lobe[t] * stopped;
        if (row->leaves[1][k] != 0) {
            at_border += stopped;
            continue;
        }
        if (begins && row->leaves[0][k] != 0) at_border[0] += stopped[0];
        if (ends && row->leaves[2][k] != 0) at_border[last] += stopped[last];
    }
    return at_border;
}

/* ---- a whole step ---- */

TY_INLINE void add_sum(float* sums, ty_lanes value) {
    ty_lanes_store(sums, ty_lanes_load(sums) + value);
}

/* Reflects the blocked light by the albedo; the rest is absorbed by surfaces. */
TY_INLINE void reflect_blocked(const cell_block* block, const float* at, int32_t channel, int32_t terms, ty_lanes* sum,
                               float sums[TY_LPV_SUMS][TY_LPV_BLOCK]) {
    const ty_lpv_row* row = block->row;
    ty_lanes lobes[TY_SH_TERMS];
    for (int32_t t = 0; t < terms; ++t) lobes[t] = (ty_lanes){0};
    add_sum(sums[TY_LPV_LEFT], -stop(block, at, terms, lobes));
    if (row->albedo[channel] == NULL) {
        add_sum(sums[TY_LPV_BLOCKED], lobes[0]);
        return;
    }
    ty_lanes albedo = {0};
    if (block->count >= TY_LANES) albedo = ty_lanes_load(row->albedo[channel] + block->begin);
    for (int32_t i = 0; block->count < TY_LANES && i < block->count; ++i)
        albedo[i] = row->albedo[channel][block->begin + i];
    add_sum(sums[TY_LPV_BLOCKED], (1.0f - albedo) * lobes[0]);
    for (int32_t t = 0; t < terms; ++t) sum[t] += albedo * lobes[t];
}

TY_INLINE void step_block(const cell_block* block, int32_t channel, int32_t terms,
                          float sums[TY_LPV_SUMS][TY_LPV_BLOCK]) {
    const ty_lpv_row* row = block->row;
    const ptrdiff_t term = row->pitch.term, place = channel * terms * term + block->begin;
    const float* at = row->from + place;
    ty_lanes sum[TY_SH_TERMS];
    for (int32_t t = 0; t < terms; ++t) sum[t] = (ty_lanes){0};
    if (terms == 4 && block->blocked_links != 0) gather_two(block, at, true, sum);
    if (terms == 4 && block->blocked_links == 0) gather_two(block, at, false, sum);
    if (terms != 4) gather_three(block, at, block->blocked_links != 0, sum);
    if (block->blocked_links != 0) reflect_blocked(block, at, channel, terms, sum, sums);
    for (int32_t t = 0; t < terms; ++t) {
        const ty_lanes value = within(sum[t], block->count);
        /* (1 - lambda) L + lambda_s-term of Eq. 3 (Billeter 2012), for the next step. */
        const float* scatter_factor = row->scatter_factor[channel][t == 0 ? 0 : t < 4 ? 1 : 2] + block->begin;
        const ty_lanes passed = value * ty_lanes_load(scatter_factor);
        ty_lanes_store(row->to + place + t * term, passed);
        if (row->sum != NULL) add_sum(row->sum + place + t * term, ty_lanes_load(at + t * term) + passed);
        if (t > 0) continue;
        add_sum(sums[TY_LPV_ARRIVED], value);
        add_sum(sums[TY_LPV_SIZE], ty_lanes_abs(value));
        add_sum(sums[TY_LPV_GOES_ON], passed);
    }
    if (!row->border) return;
    ty_lanes left = {0};
    for (int32_t t = 0; t < terms; ++t) left += row->out[1][t] * ty_lanes_load(at + t * term);
    add_sum(sums[TY_LPV_LEFT], left);
}

/* Light that the ends of a row send out of the lattice, in excess of the cells between them. */
TY_INLINE float left_at_ends(const ty_lpv_row* row, int32_t channel, int32_t terms) {
    const float* at = row->from + channel * terms * row->pitch.term;
    float left = 0.0f;
    for (int32_t t = 0; t < terms; ++t, at += row->pitch.term) {
        left += (row->out[0][t] - row->out[1][t]) * at[0];
        if (row->count > 1) left += (row->out[2][t] - row->out[1][t]) * at[row->count - 1];
    }
    return left;
}

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
    cell_block block;
    block.row = row;
    block.begin = 0;
    if (row->blocked_links != NULL) set_all_transparent(&block, all_links);
    if (row->count > WIDE) fetch_next(row);
    for (; block.begin < row->count; block.begin += TY_LANES) {
        block.count = row->count - block.begin;
        block.blocked_links = row->blocked_links != NULL ? row->blocked_links[block.begin / TY_LPV_BLOCK] : 0;
        find_transmission(&block);
        for (int32_t c = 0; c < 3; ++c) step_block(&block, c, terms, sums->sums[c]);
        set_all_transparent(&block, block.blocked_links);
    }
    for (int32_t c = 0; c < 3; ++c) sums->sums[c][TY_LPV_LEFT][0] += left_at_ends(row, c, terms);
}

static void step(const ty_lpv_row* row, ty_lpv_lane_sums* sums) {
    if (row->terms == 4)
        step_row(row, 4, sums);
    else
        step_row(row, TY_SH_TERMS, sums);
}

const ty_lpv_kernels TY_KERNEL_NAME(ty_lpv_kernels) = {.step = step};
