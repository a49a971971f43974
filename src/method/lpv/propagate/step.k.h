/* One iteration of propagation for neighbouring cells of a row: as many as this machine's vectors have lanes, one on
 * other devices. */
#ifndef TY_METHOD_LPV_PROPAGATE_STEP_K_H
#define TY_METHOD_LPV_PROPAGATE_STEP_K_H

#include "base/lanes.k.h"
#include "method/lpv/propagate/kernel.h"

/* All links: their directions and indices. */
#define TY_LPV_EACH_LINK(LINK)                                                                                         \
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
typedef struct ty_lpv_cells {
    const ty_lpv_row* row;
    int32_t begin, count;
    uint32_t blocked_links; /* bits of the blocked links */
    _Alignas(TY_LANE_BYTES) float transmission[TY_LPV_LINKS][TY_LANES];
} ty_lpv_cells;

/* Zeroes lanes past the row's end. */
TY_INLINE ty_lanes ty_lpv_within(ty_lanes value, int32_t count) {
    if (count >= TY_LANES) return value;
    for (int i = 0; i < TY_LANES; ++i)
        if (i >= count) value[i] = 0.0f;
    return value;
}

/* value + step * term for a constant step of -1, 0 or 1. */
TY_INLINE ty_lanes ty_lpv_with(ty_lanes value, int32_t step, ty_lanes term) {
    return step == 0 ? value : step > 0 ? value + term : value - term;
}

/* Number of axes that a link moves along. */
TY_INLINE int32_t ty_lpv_link_axes(int32_t dx, int32_t dy, int32_t dz) {
    return (dx != 0) + (dy != 0) + (dz != 0);
}

/* ---- two bands ---- */

/* <L | G_j> of one cell and link. `at`: its first term. */
TY_INLINE ty_lanes ty_lpv_along_two(const float* at, ptrdiff_t term, const ty_lpv_link_functions* link_functions,
                                    int32_t dx, int32_t dy, int32_t dz) {
    const int32_t kind = ty_lpv_link_axes(dx, dy, dz) - 1;
    const float band1 = link_functions->band1[kind];
    ty_lanes value = link_functions->band0[kind] * ty_lanes_load(at);
    if (dy != 0) value = ty_lpv_with(value, dy, band1 * ty_lanes_load(at + term));
    if (dz != 0) value = ty_lpv_with(value, dz, band1 * ty_lanes_load(at + 2 * term));
    if (dx != 0) value = ty_lpv_with(value, dx, band1 * ty_lanes_load(at + 3 * term));
    return value;
}

TY_INLINE void ty_lpv_add_two(ty_lanes sum[4], ty_lanes value, float band0, float band1, int32_t dx, int32_t dy,
                              int32_t dz) {
    sum[0] += band0 * value;
    sum[1] = ty_lpv_with(sum[1], dy, band1 * value);
    sum[2] = ty_lpv_with(sum[2], dz, band1 * value);
    sum[3] = ty_lpv_with(sum[3], dx, band1 * value);
}

/* Eq. 3 (Billeter 2012): the sum over j of dL_j = (1 - b_j) <L' | G_j> G_j, where L' is the light of the neighbour with
 * the scattering operator already applied (propagate/transfer.c), and 1 - b_j is the transmission. */
TY_INLINE void ty_lpv_gather_two(const ty_lpv_cells* block, const float* at, bool blocked_links, ty_lanes sum[4]) {
    const ty_lpv_row* row = block->row;
    const ty_lpv_link_functions* link_functions = row->link_functions;
    const ptrdiff_t term = row->pitch.term, to_row = row->pitch.row, to_plane = row->pitch.plane;
#define LINK(dx, dy, dz, k)                                                                                            \
    {                                                                                                                  \
        const int32_t kind = ty_lpv_link_axes(dx, dy, dz) - 1;                                                         \
        const float* source = at - (dx) - (dy)*to_row - (dz)*to_plane;                                                 \
        ty_lanes value = ty_lpv_along_two(source, term, link_functions, dx, dy, dz);                                   \
        if (blocked_links) value *= ty_lanes_load(block->transmission[k]);                                             \
        ty_lpv_add_two(sum, value, link_functions->band0[kind], link_functions->band1[kind], dx, dy, dz);              \
    }
    TY_LPV_EACH_LINK(LINK)
#undef LINK
}

/* ---- three bands ---- */

/* Eq. 3 (Billeter 2012), as ty_lpv_gather_two. */
TY_INLINE void ty_lpv_gather_three(const ty_lpv_cells* block, const float* at, bool blocked_links,
                                   ty_lanes sum[TY_SH_TERMS]) {
    const ty_lpv_row* row = block->row;
    const ptrdiff_t term = row->pitch.term, to_row = row->pitch.row, to_plane = row->pitch.plane;
#define LINK(dx, dy, dz, k)                                                                                            \
    {                                                                                                                  \
        const float* source = at - (dx) - (dy)*to_row - (dz)*to_plane;                                                 \
        const float* transfer_G = row->link_functions->G[k];                                                           \
        ty_lanes value = transfer_G[0] * ty_lanes_load(source);                                                        \
        TY_UNROLL                                                                                                      \
        for (int32_t t = 1; t < TY_SH_TERMS; ++t) value += transfer_G[t] * ty_lanes_load(source + t * term);           \
        if (blocked_links) value *= ty_lanes_load(block->transmission[k]);                                             \
        TY_UNROLL                                                                                                      \
        for (int32_t t = 0; t < TY_SH_TERMS; ++t) sum[t] += transfer_G[t] * value;                                     \
    }
    TY_LPV_EACH_LINK(LINK)
#undef LINK
}

/* ---- surfaces ---- */

static const uint32_t ty_lpv_all_links = (1u << TY_LPV_LINKS) - 1;

/* Removes and returns the next link of a set. */
TY_INLINE int32_t ty_lpv_take_link(uint32_t* links) {
    const int32_t k = __builtin_ctz(*links);
    *links &= *links - 1;
    return k;
}

/* Full transmission of all links of a set: the state that ty_lpv_find_transmission starts from. */
TY_INLINE void ty_lpv_set_transparent(ty_lpv_cells* block, uint32_t links) {
    while (links != 0) {
        const int32_t k = ty_lpv_take_link(&links);
        for (int32_t i = 0; i < TY_LANES; ++i) block->transmission[k][i] = 1.0f;
    }
}

/* Transmission of the links into the block, 0..1. */
TY_INLINE void ty_lpv_find_transmission(ty_lpv_cells* block) {
    const size_t first = block->row->first + (size_t)block->begin;
    for (uint32_t links = block->blocked_links; links != 0;) {
        const int32_t k = ty_lpv_take_link(&links);
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
TY_INLINE ty_lanes ty_lpv_stop(const ty_lpv_cells* block, const float* at, int32_t terms, ty_lanes* lobes) {
    const ty_lpv_row* row = block->row;
    const int32_t last = row->count - 1 - block->begin;
    const bool begins = block->begin == 0, ends = row->count > 1 && last < TY_LANES;
    ty_lanes own[TY_SH_TERMS], at_border = {0};
    TY_UNROLL
    for (int32_t t = 0; t < terms; ++t) own[t] = ty_lanes_load(at + t * row->pitch.term);
    for (uint32_t links = block->blocked_links; links != 0;) {
        const int32_t k = ty_lpv_take_link(&links);
        const float* transfer_G =
            row->link_functions->G[k < TY_LPV_HALF_LINKS ? k + TY_LPV_HALF_LINKS : k - TY_LPV_HALF_LINKS];
        const float* lobe = row->link_functions->lobes[k];
        ty_lanes leaving = transfer_G[0] * own[0];
        TY_UNROLL
        for (int32_t t = 1; t < terms; ++t) leaving += transfer_G[t] * own[t];
        const ty_lanes stopped = (1.0f - ty_lanes_load(block->transmission[k])) * (transfer_G[0] * leaving);
        lobes[0] += stopped;
        TY_UNROLL
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

TY_INLINE void ty_lpv_add_sum(float* sums, ty_lanes value) {
    ty_lanes_store(sums, ty_lanes_load(sums) + value);
}

/* Reflects the blocked light by the albedo; the rest is absorbed by surfaces. */
TY_INLINE void ty_lpv_reflect_blocked(const ty_lpv_cells* block, const float* at, int32_t channel, int32_t terms,
                                      ty_lanes* sum, float sums[TY_LPV_SUMS][TY_LPV_BLOCK]) {
    const ty_lpv_row* row = block->row;
    ty_lanes lobes[TY_SH_TERMS];
    TY_UNROLL
    for (int32_t t = 0; t < terms; ++t) lobes[t] = (ty_lanes){0};
    ty_lpv_add_sum(sums[TY_LPV_LEFT], -ty_lpv_stop(block, at, terms, lobes));
    if (row->albedo[channel] == NULL) {
        ty_lpv_add_sum(sums[TY_LPV_BLOCKED], lobes[0]);
        return;
    }
    ty_lanes albedo = {0};
    if (block->count >= TY_LANES) albedo = ty_lanes_load(row->albedo[channel] + block->begin);
    for (int32_t i = 0; block->count < TY_LANES && i < block->count; ++i)
        albedo[i] = row->albedo[channel][block->begin + i];
    ty_lpv_add_sum(sums[TY_LPV_BLOCKED], (1.0f - albedo) * lobes[0]);
    TY_UNROLL
    for (int32_t t = 0; t < terms; ++t) sum[t] += albedo * lobes[t];
}

TY_INLINE void ty_lpv_step_cells(const ty_lpv_cells* block, int32_t channel, int32_t terms,
                                 float sums[TY_LPV_SUMS][TY_LPV_BLOCK]) {
    const ty_lpv_row* row = block->row;
    const ptrdiff_t term = row->pitch.term, place = channel * terms * term + block->begin;
    const float* at = row->from + place;
    ty_lanes sum[TY_SH_TERMS];
    TY_UNROLL
    for (int32_t t = 0; t < terms; ++t) sum[t] = (ty_lanes){0};
    if (terms == 4 && block->blocked_links != 0) ty_lpv_gather_two(block, at, true, sum);
    if (terms == 4 && block->blocked_links == 0) ty_lpv_gather_two(block, at, false, sum);
    if (terms != 4) ty_lpv_gather_three(block, at, block->blocked_links != 0, sum);
    if (block->blocked_links != 0) ty_lpv_reflect_blocked(block, at, channel, terms, sum, sums);
    TY_UNROLL
    for (int32_t t = 0; t < terms; ++t) {
        const ty_lanes value = ty_lpv_within(sum[t], block->count);
        /* (1 - lambda) L + lambda_s-term of Eq. 3 (Billeter 2012), for the next step. */
        const float* scatter_factor = row->scatter_factor[channel][t == 0 ? 0 : t < 4 ? 1 : 2] + block->begin;
        const ty_lanes passed = value * ty_lanes_load(scatter_factor);
        ty_lanes_store(row->to + place + t * term, passed);
        if (row->sum != NULL) ty_lpv_add_sum(row->sum + place + t * term, ty_lanes_load(at + t * term) + passed);
        if (t > 0) continue;
        ty_lpv_add_sum(sums[TY_LPV_ARRIVED], value);
        ty_lpv_add_sum(sums[TY_LPV_SIZE], ty_lanes_abs(value));
        ty_lpv_add_sum(sums[TY_LPV_GOES_ON], passed);
    }
    if (!row->border) return;
    ty_lanes left = {0};
    TY_UNROLL
    for (int32_t t = 0; t < terms; ++t) left += row->out[1][t] * ty_lanes_load(at + t * term);
    ty_lpv_add_sum(sums[TY_LPV_LEFT], left);
}

/* Light that the ends of a row send out of the lattice, in excess of the cells between them. */
TY_INLINE float ty_lpv_left_at_ends(const ty_lpv_row* row, int32_t channel, int32_t terms) {
    const float* at = row->from + channel * terms * row->pitch.term;
    float left = 0.0f;
    for (int32_t t = 0; t < terms; ++t, at += row->pitch.term) {
        left += (row->out[0][t] - row->out[1][t]) * at[0];
        if (row->count > 1) left += (row->out[2][t] - row->out[1][t]) * at[row->count - 1];
    }
    return left;
}

#endif
