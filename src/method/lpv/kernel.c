/* Light in a row of cells goes one step; built once per instruction set, with TY_ISA naming it. */
#include "method/lpv/kernel.h"

#include <stdlib.h>

#if defined(__AVX512F__)
enum { BYTES = 64 };
#elif defined(__AVX__)
enum { BYTES = 32 };
#else
enum { BYTES = 16 };
#endif
enum { LANES = BYTES / sizeof(float) };

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)
#define TY_INLINE static inline __attribute__((always_inline))

typedef float lanes __attribute__((vector_size(BYTES)));
typedef int32_t whole_lanes __attribute__((vector_size(BYTES)));

/* All links: where they go, and their numbers. */
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

/* Up to LANES cells of a row, and what links into them let pass. */
typedef struct cell_block {
    const ty_lpv_row* row;
    int32_t begin, count;
    bool near; /* whether any of the links is not open */
    float open[TY_LPV_LINKS][LANES];
} cell_block;

TY_INLINE lanes load(const float* from) {
    lanes value;
    memcpy(&value, from, sizeof value);
    return value;
}

TY_INLINE void store(float* to, lanes value) {
    memcpy(to, &value, sizeof value);
}

TY_INLINE float total(lanes value) {
    float sum = 0.0f;
    for (int i = 0; i < LANES; ++i) sum += value[i];
    return sum;
}

TY_INLINE lanes size_of(lanes value) {
    whole_lanes bits;
    memcpy(&bits, &value, sizeof bits);
    bits &= 0x7fffffff;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Nothing in lanes past the row's end. */
TY_INLINE lanes within(lanes value, int32_t count) {
    if (count >= LANES) return value;
    for (int i = 0; i < LANES; ++i)
        if (i >= count) value[i] = 0.0f;
    return value;
}

/* value + step * term, for a step of -1, 0 or 1 that the compiler knows. */
TY_INLINE lanes with(lanes value, int32_t step, lanes term) {
    return step == 0 ? value : step > 0 ? value + term : value - term;
}

/* ---- two bands ---- */

/* What of one cell's light goes along a link. `at` is its first term. */
TY_INLINE lanes along_two(const float* at, ptrdiff_t term, const ty_lpv_shapes* shapes, int32_t dx, int32_t dy,
                          int32_t dz) {
    const int32_t kind = abs(dx) + abs(dy) + abs(dz) - 1;
    const float along = shapes->along[kind];
    lanes value = shapes->even[kind] * load(at);
    if (dy != 0) value = with(value, dy, along * load(at + term));
    if (dz != 0) value = with(value, dz, along * load(at + 2 * term));
    if (dx != 0) value = with(value, dx, along * load(at + 3 * term));
    return value;
}

TY_INLINE void add_two(lanes sum[4], lanes value, float even, float along, int32_t dx, int32_t dy, int32_t dz) {
    sum[0] += even * value;
    sum[1] = with(sum[1], dy, along * value);
    sum[2] = with(sum[2], dz, along * value);
    sum[3] = with(sum[3], dx, along * value);
}

TY_INLINE void gather_two(const cell_block* block, const float* at, bool near, lanes sum[4]) {
    const ty_lpv_row* row = block->row;
    const ty_lpv_shapes* shapes = row->shapes;
    const ptrdiff_t term = row->pitch.term, to_row = row->pitch.row, to_plane = row->pitch.plane;
#define LINK(dx, dy, dz, k)                                                                                            \
    {                                                                                                                  \
        const int32_t kind = abs(dx) + abs(dy) + abs(dz) - 1;                                                          \
        const float* source = at - (dx) - (dy) * to_row - (dz) * to_plane;                                             \
        lanes value = along_two(source, term, shapes, dx, dy, dz);                                                     \
        if (near) value *= load(block->open[k]);                                                                       \
        add_two(sum, value, shapes->even[kind], shapes->along[kind], dx, dy, dz);                                      \
    }
    EACH_LINK(LINK)
#undef LINK
}

/* What surfaces stop on the way out, by its lobes back, and what of it would have left the lattice. */
TY_INLINE lanes stop_two(const cell_block* block, const float* at, lanes lobes[4], float left[3]) {
    const ty_lpv_row* row = block->row;
    const ty_lpv_shapes* shapes = row->shapes;
    const int32_t last = row->count - 1 - block->begin;
    lanes stopped_at_border = {0};
#define LINK(dx, dy, dz, k)                                                                                            \
    {                                                                                                                  \
        const int32_t kind = abs(dx) + abs(dy) + abs(dz) - 1;                                                          \
        const lanes leaving = along_two(at, row->pitch.term, shapes, -(dx), -(dy), -(dz));                             \
        const lanes stopped = (1.0f - load(block->open[k])) * (shapes->even[kind] * leaving);                          \
        add_two(lobes, stopped, 1.0f, shapes->lobe[kind], dx, dy, dz);                                                 \
        if (row->leaves[1][k] != 0) stopped_at_border += stopped;                                                      \
        if (block->begin == 0 && row->leaves[0][k] != row->leaves[1][k]) left[0] += stopped[0];                        \
        if (row->count > 1 && last < LANES && row->leaves[2][k] != row->leaves[1][k])                         \
            left[2] += stopped[last];                                                                                  \
    }
    EACH_LINK(LINK)
#undef LINK
    return stopped_at_border;
}

/* ---- three bands ---- */

TY_INLINE void gather_three(const cell_block* block, const float* at, bool near, lanes sum[TY_SH_TERMS]) {
    const ty_lpv_row* row = block->row;
    const ptrdiff_t term = row->pitch.term, to_row = row->pitch.row, to_plane = row->pitch.plane;
#define LINK(dx, dy, dz, k)                                                                                            \
    {                                                                                                                  \
        const float* source = at - (dx) - (dy) * to_row - (dz) * to_plane;                                             \
        const float* shape = row->shapes->all[k];                                                                      \
        lanes value = shape[0] * load(source);                                                                         \
        for (int32_t t = 1; t < TY_SH_TERMS; ++t) value += shape[t] * load(source + t * term);                         \
        if (near) value *= load(block->open[k]);                                                                       \
        for (int32_t t = 0; t < TY_SH_TERMS; ++t) sum[t] += shape[t] * value;                                          \
    }
    EACH_LINK(LINK)
#undef LINK
}

TY_INLINE lanes stop_three(const cell_block* block, const float* at, lanes lobes[TY_SH_TERMS], float left[3]) {
    const ty_lpv_row* row = block->row;
    const int32_t last = row->count - 1 - block->begin;
    lanes stopped_at_border = {0};
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
        const float *shape = row->shapes->all[k < TY_LPV_HALF_LINKS ? k + TY_LPV_HALF_LINKS : k - TY_LPV_HALF_LINKS],
                    *lobe = row->shapes->lobes[k];
        lanes leaving = shape[0] * load(at);
        for (int32_t t = 1; t < TY_SH_TERMS; ++t) leaving += shape[t] * load(at + t * row->pitch.term);
        const lanes stopped = (1.0f - load(block->open[k])) * (shape[0] * leaving);
        for (int32_t t = 0; t < TY_SH_TERMS; ++t) lobes[t] += lobe[t] * stopped;
        if (row->leaves[1][k] != 0) stopped_at_border += stopped;
        if (block->begin == 0 && row->leaves[0][k] != row->leaves[1][k]) left[0] += stopped[0];
        if (row->count > 1 && last < LANES && row->leaves[2][k] != row->leaves[1][k]) left[2] += stopped[last];
    }
    return stopped_at_border;
}

/* ---- all bands ---- */

/* What links into the block let pass, 0..1. */
TY_INLINE void find_open(cell_block* block) {
    const size_t first = block->row->first + (size_t)block->begin;
    const int32_t count = block->count < LANES ? block->count : LANES;
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
        const uint8_t* from = block->row->open[k] + first;
        if (count == LANES) {
            for (int32_t i = 0; i < LANES; ++i) block->open[k][i] = (float)from[i] * (1.0f / 255.0f);
            continue;
        }
        for (int32_t i = 0; i < LANES; ++i) block->open[k][i] = i < count ? (float)from[i] * (1.0f / 255.0f) : 1.0f;
    }
}

/* Sums of a channel, a lane a cell; what the ends' stopped light takes from what leaves is apart. */
typedef struct lane_sums {
    lanes arrived, size, goes_on, kept, left;
    float ends[3];
} lane_sums;

/* Light stopped near the block's cells comes back to them; the rest of it is surfaces'. */
TY_INLINE void turn_back(const cell_block* block, const float* at, int32_t channel, int32_t terms, lanes* sum,
                         lane_sums* sums) {
    const ty_lpv_row* row = block->row;
    lanes lobes[TY_SH_TERMS] = {{0}};
    sums->left -= terms == 4 ? stop_two(block, at, lobes, sums->ends) : stop_three(block, at, lobes, sums->ends);
    if (row->albedo[channel] == NULL) {
        sums->kept += lobes[0];
        return;
    }
    lanes albedo = {0};
    for (int32_t i = 0; i < LANES && i < block->count; ++i) albedo[i] = row->albedo[channel][block->begin + i];
    sums->kept += (1.0f - albedo) * lobes[0];
    for (int32_t t = 0; t < terms; ++t) sum[t] += albedo * lobes[t];
}

TY_INLINE void step_block(const cell_block* block, int32_t channel, int32_t terms, lane_sums* sums) {
    const ty_lpv_row* row = block->row;
    const ptrdiff_t term = row->pitch.term, place = channel * terms * term + block->begin;
    const float* at = row->from + place;
    lanes sum[TY_SH_TERMS] = {{0}};
    if (terms == 4 && block->near) gather_two(block, at, true, sum);
    if (terms == 4 && !block->near) gather_two(block, at, false, sum);
    if (terms != 4) gather_three(block, at, block->near, sum);
    if (block->near) turn_back(block, at, channel, terms, sum, sums);
    for (int32_t t = 0; t < terms; ++t) {
        const lanes value = within(sum[t], block->count);
        const lanes passed = value * load(row->pass[channel][t == 0 ? 0 : t < 4 ? 1 : 2] + block->begin);
        float* add = row->sum + place + t * term;
        store(row->to + place + t * term, passed);
        store(add, load(add) + value);
        if (t > 0) continue;
        sums->arrived += value;
        sums->size += size_of(value);
        sums->goes_on += passed;
    }
    if (!row->border) return;
    for (int32_t t = 0; t < terms; ++t) sums->left += row->out[1][t] * load(at + t * term);
}

/* What the ends of a row send out of the lattice beyond what cells between them do. */
TY_INLINE float left_at_ends(const ty_lpv_row* row, int32_t channel, int32_t terms) {
    const float* at = row->from + channel * terms * row->pitch.term;
    float left = 0.0f;
    for (int32_t t = 0; t < terms; ++t, at += row->pitch.term) {
        left += (row->out[0][t] - row->out[1][t]) * at[0];
        if (row->count > 1) left += (row->out[2][t] - row->out[1][t]) * at[row->count - 1];
    }
    return left;
}

TY_INLINE void step_row(const ty_lpv_row* row, int32_t terms, ty_lpv_row_sums* out) {
    lane_sums sums[3] = {{.arrived = {0}}};
    cell_block block = {.row = row};
    for (; block.begin < row->count; block.begin += LANES) {
        block.count = row->count - block.begin;
        block.near = row->near != NULL && row->near[block.begin / TY_LPV_BLOCK] != 0;
        if (block.near) find_open(&block);
        for (int32_t c = 0; c < 3; ++c) step_block(&block, c, terms, &sums[c]);
    }
    for (int32_t c = 0; c < 3; ++c) {
        out->arrived[c] = total(sums[c].arrived);
        out->size[c] = total(sums[c].size);
        out->goes_on[c] = total(sums[c].goes_on);
        out->kept[c] = total(sums[c].kept);
        out->left[c] = total(sums[c].left) + left_at_ends(row, c, terms) - sums[c].ends[0] - sums[c].ends[2];
    }
}

static void step(const ty_lpv_row* row, ty_lpv_row_sums* sums) {
    if (row->terms == 4)
        step_row(row, 4, sums);
    else
        step_row(row, TY_SH_TERMS, sums);
}

const ty_lpv_kernels TY_JOIN(ty_lpv_kernels_, TY_ISA) = {.step = step};
