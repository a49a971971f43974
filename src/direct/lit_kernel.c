/* Lines through a pyramid side by side; see lit_kernel.h. Each goes on by one block at a time, as in ty_lit_walk. */
#include "direct/lit_kernel.h"

#include "base/simd.h"

enum { LINES = TY_LIT_LINES };
_Static_assert(sizeof(ty_float16) == LINES * sizeof(float), "one lane per line");

/* What goes on along lines; LINES of each. */
typedef struct line_set {
    ty_float16 x, y, near, dx, dy, dnear, per_x, per_y;
    ty_int16 ahead_x, ahead_y; /* 1: to greater places */
    ty_int16 at_x, at_y, level, lit, active;
    ty_float16 u;
} line_set;

#define CHOOSE(mask, a, b) (((a) & (mask)) | ((b) & ~(mask)))
#define CHOOSE_REAL(mask, a, b) ((ty_float16)CHOOSE(mask, (ty_int16)(a), (ty_int16)(b)))
#define LEAST(a, b) CHOOSE_REAL((a) < (b), a, b)
#define MOST(a, b) CHOOSE_REAL((a) > (b), a, b)
#define TO_WHOLE(a) __builtin_convertvector(a, ty_int16)
#define TO_REAL(a) __builtin_convertvector(a, ty_float16)

TY_INLINE void begin(const ty_lit_line* lines, int32_t count, int32_t side, int32_t top, const ty_lit_run* runs,
                     line_set* set) {
    memset(set, 0, sizeof *set);
    for (int32_t i = 0; i < LINES; ++i) {
        const ty_lit_line* line = &lines[i < count ? i : 0];
        set->x[i] = line->x;
        set->y[i] = line->y;
        set->near[i] = line->near;
        set->dx[i] = ty_lit_slanting(line->dx);
        set->dy[i] = ty_lit_slanting(line->dy);
        set->dnear[i] = line->dnear;
        set->at_x[i] = ty_lit_clamp((int32_t)line->x, 0, side - 1);
        set->at_y[i] = ty_lit_clamp((int32_t)line->y, 0, side - 1);
        set->level[i] = ty_lit_first_level(line, top);
        set->lit[i] = runs[i < count ? i : 0].lit;
        set->active[i] = i < count ? -1 : 0;
    }
    set->per_x = 1.0f / set->dx;
    set->per_y = 1.0f / set->dy;
    set->ahead_x = (set->dx > 0.0f) & 1;
    set->ahead_y = (set->dy > 0.0f) & 1;
}

/* What changes within blocks: lines that turn dark or lit, one by one. */
TY_INLINE void turn(const ty_lit_line* lines, const ty_int16* turns, const ty_int16* before, const ty_float16* node,
                    const ty_float16* leave, line_set* set, ty_lit_run* runs) {
    for (int32_t i = 0; i < LINES; ++i) {
        if ((*turns)[i] == 0) continue;
        if (set->level[i] == 0)
            ty_lit_pass_texel(&lines[i], (*node)[i], set->u[i], (*leave)[i], &runs[i]);
        else
            ty_lit_turn(&runs[i], ty_lit_line_at(&lines[i], set->u[i]), (*before)[i] & 1);
        set->lit[i] = runs[i].lit;
    }
}

static void walk(const ty_lit_face* face, const ty_lit_line* lines, int32_t count, int32_t side, int32_t top,
                 ty_lit_run* runs) {
    line_set set;
    ty_int16 offsets = {0}, widths = {0};
    begin(lines, count, side, top, runs, &set);
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
        const ty_float16 here = set.near + set.u * set.dnear, there = set.near + leave * set.dnear;
        const ty_int16 before = LEAST(here, there) >= high, behind = MOST(here, there) < low;
        const ty_int16 unsure = ~(before | behind), fine = level == 0;
        const ty_int16 descends = unsure & ~fine & set.active, stays = set.active & ~descends;
        const ty_int16 turns = stays & ((unsure & fine) | ((before & 1) != set.lit));
        if (ty_any16(&turns)) turn(lines, &turns, &before, &low, &leave, &set, runs);
        const ty_int16 by_x = u_x < u_y, last = (1 << level) - 1;
        const ty_int16 low_x = block_x << level, low_y = block_y << level;
        const ty_int16 slid_x = TO_WHOLE(set.x + leave * set.dx), slid_y = TO_WHOLE(set.y + leave * set.dy);
        const ty_int16 kept_x = CHOOSE(slid_x < low_x, low_x, CHOOSE(slid_x > low_x + last, low_x + last, slid_x));
        const ty_int16 kept_y = CHOOSE(slid_y < low_y, low_y, CHOOSE(slid_y > low_y + last, low_y + last, slid_y));
        const ty_int16 next_x = CHOOSE(by_x, edge_x - (1 - set.ahead_x), kept_x);
        const ty_int16 next_y = CHOOSE(by_x, kept_y, edge_y - (1 - set.ahead_y));
        const ty_int16 ends = (leave >= 1.0f) | (next_x < 0) | (next_y < 0) | (next_x >= side) | (next_y >= side);
        const ty_int16 even = (CHOOSE(by_x, block_x, block_y) & 1) == CHOOSE(by_x, set.ahead_x, set.ahead_y);
        set.at_x = CHOOSE(stays, next_x, set.at_x);
        set.at_y = CHOOSE(stays, next_y, set.at_y);
        set.u = CHOOSE_REAL(stays, leave, set.u);
        set.level = level + CHOOSE(stays, (even & (level < top)) & 1, descends);
        set.active &= ~(stays & ends);
        /* Lines that have ended stay within the map. */
        set.at_x &= set.active;
        set.at_y &= set.active;
    }
}

const ty_lit_kernels TY_KERNEL_NAME(ty_lit_kernels) = {.walk = walk};
