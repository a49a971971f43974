/* Traversal of many lines in SIMD lanes; each lane advances by one block at a time, as in ty_shadow_traverse. */
#include "direct/shadow/shadow_hierarchy_kernel.h"

#include "base/simd.h"

enum { LINES = TY_SHADOW_RAYS_MAX };
_Static_assert(sizeof(ty_float16) == LINES * sizeof(float), "one lane per line");

/* The traversal state of all lines, one lane each. */
typedef struct line_set {
    ty_float16 x, y, inverse_depth, dx, dy, inverse_depth_change, per_x, per_y;
    ty_int16 ahead_x, ahead_y; /* 1: towards larger coordinates */
    ty_int16 at_x, at_y, level, lit, active;
    ty_float16 u;
} line_set;

#define CHOOSE(mask, a, b) (((a) & (mask)) | ((b) & ~(mask)))
#define CHOOSE_REAL(mask, a, b) ((ty_float16)CHOOSE(mask, (ty_int16)(a), (ty_int16)(b)))
#define LEAST(a, b) CHOOSE_REAL((a) < (b), a, b)
#define MOST(a, b) CHOOSE_REAL((a) > (b), a, b)
#define TO_WHOLE(a) __builtin_convertvector(a, ty_int16)
#define TO_REAL(a) __builtin_convertvector(a, ty_float16)

TY_INLINE void begin(const ty_shadow_line* lines, int32_t count, int32_t side, int32_t top,
                     const ty_lit_segments* lists, line_set* set) {
    memset(set, 0, sizeof *set);
    for (int32_t i = 0; i < LINES; ++i) {
        const ty_shadow_line* line = &lines[i < count ? i : 0];
        set->x[i] = line->x;
        set->y[i] = line->y;
        set->inverse_depth[i] = line->inverse_depth;
        set->dx[i] = ty_shadow_slope(line->dx);
        set->dy[i] = ty_shadow_slope(line->dy);
        set->inverse_depth_change[i] = line->inverse_depth_change;
        set->at_x[i] = ty_shadow_clamp((int32_t)line->x, 0, side - 1);
        set->at_y[i] = ty_shadow_clamp((int32_t)line->y, 0, side - 1);
        set->level[i] = ty_shadow_first_level(line, top);
        set->lit[i] = lists[i < count ? i : 0].lit;
        set->active[i] = i < count ? -1 : 0;
    }
    set->per_x = 1.0f / set->dx;
    set->per_y = 1.0f / set->dy;
    set->ahead_x = (set->dx > 0.0f) & 1;
    set->ahead_y = (set->dy > 0.0f) & 1;
}

/* Lines whose visibility changes inside a block, one by one. */
TY_INLINE void switch_visibility(const ty_shadow_line* lines, const ty_int16* switches, const ty_int16* before,
                                 const ty_float16* node, const ty_float16* leave, line_set* set,
                                 ty_lit_segments* lists) {
    for (int32_t i = 0; i < LINES; ++i) {
        if ((*switches)[i] == 0) continue;
        if (set->level[i] == 0)
            ty_shadow_cross_texel(&lines[i], (*node)[i], set->u[i], (*leave)[i], &lists[i]);
        else
            ty_lit_segments_switch(&lists[i], ty_shadow_line_distance(&lines[i], set->u[i]), (*before)[i] & 1);
        set->lit[i] = lists[i].lit;
    }
}

static void walk(const ty_shadow_face* face, const ty_shadow_line* lines, int32_t count, int32_t side, int32_t top,
                 ty_lit_segments* lists) {
    line_set set;
    ty_int16 offsets = {0}, widths = {0};
    begin(lines, count, side, top, lists, &set);
    for (int32_t i = 0; i <= top; ++i) {
        offsets[i] = (int32_t)face->offset[i];
        widths[i] = (side + (1 << i) - 1) >> i;
    }
    while (ty_any16(&set.active)) {
        const ty_int16 level = set.level, coarse = (level > 0) & 1;
        const ty_int16 block_x = set.at_x >> level, block_y = set.at_y >> level;
        const ty_int16 edge_x = (block_x + set.ahead_x) << level, edge_y = (block_y + set.ahead_y) << level;
        const ty_float16 u_x = (TO_REAL(edge_x) - set.x) * set.per_x, u_y = (TO_REAL(edge_y) - set.y) * set.per_y;
        const ty_float16 first = LEAST(u_x, u_y), capped = CHOOSE_REAL(first < 1.0f, first, (ty_float16){0} + 1.0f);
        const ty_float16 leave = MOST(set.u, capped);
        ty_int16 width, offset;
        ty_permute16(&widths, &level, &width);
        ty_permute16(&offsets, &level, &offset);
        const ty_int16 place = (block_y * width + block_x) << coarse;
        const ty_int16 node = (offset + place) & set.active;
        const ty_int16 node_high = node + (coarse & set.active);
        ty_float16 low, high;
        ty_gather16(face->nodes, &node, &low);
        ty_gather16(face->nodes, &node_high, &high);
        const ty_float16 here = set.inverse_depth + set.u * set.inverse_depth_change,
                         there = set.inverse_depth + leave * set.inverse_depth_change;
        const ty_int16 before = LEAST(here, there) >= high, behind = MOST(here, there) < low;
        const ty_int16 unsure = ~(before | behind), fine = level == 0;
        const ty_int16 descends = unsure & ~fine & set.active, stays = set.active & ~descends;
        const ty_int16 switches = stays & ((unsure & fine) | ((before & 1) != set.lit));
        if (ty_any16(&switches)) switch_visibility(lines, &switches, &before, &low, &leave, &set, lists);
        const ty_int16 by_x = u_x < u_y, last = (1 << level) - 1;
        const ty_int16 low_x = block_x << level, low_y = block_y << level;
        const ty_int16 slid_x = TO_WHOLE(set.x + leave * set.dx), slid_y = TO_WHOLE(set.y + leave * set.dy);
        const ty_int16 clamped_x = CHOOSE(slid_x < low_x, low_x, CHOOSE(slid_x > low_x + last, low_x + last, slid_x));
        const ty_int16 clamped_y = CHOOSE(slid_y < low_y, low_y, CHOOSE(slid_y > low_y + last, low_y + last, slid_y));
        const ty_int16 next_x = CHOOSE(by_x, edge_x - (1 - set.ahead_x), clamped_x);
        const ty_int16 next_y = CHOOSE(by_x, clamped_y, edge_y - (1 - set.ahead_y));
        const ty_int16 ends = (leave >= 1.0f) | (next_x < 0) | (next_y < 0) | (next_x >= side) | (next_y >= side);
        const ty_int16 at_parent_edge = (CHOOSE(by_x, block_x, block_y) & 1) == CHOOSE(by_x, set.ahead_x, set.ahead_y);
        set.at_x = CHOOSE(stays, next_x, set.at_x);
        set.at_y = CHOOSE(stays, next_y, set.at_y);
        set.u = CHOOSE_REAL(stays, leave, set.u);
        set.level = level + CHOOSE(stays, (at_parent_edge & (level < top)) & 1, descends);
        set.active &= ~(stays & ends);
        /* Finished lines keep a valid texel. */
        set.at_x &= set.active;
        set.at_y &= set.active;
    }
}

const ty_shadow_kernels TY_KERNEL_NAME(ty_shadow_kernels) = {.walk = walk};
