/* Lines through a pyramid side by side; see lit_kernel.h. Each goes on by one block at a time, as in ty_lit_walk. */
#include "direct/shadow/lit_kernel.h"

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)
#define TY_INLINE static inline __attribute__((always_inline))

enum { LINES = TY_LIT_LINES, BYTES = LINES * sizeof(float) };

typedef float reals __attribute__((vector_size(BYTES)));
typedef int32_t wholes __attribute__((vector_size(BYTES))); /* also masks: 0 or -1 */

/* What goes on along lines; LINES of each. */
typedef struct line_set {
    reals x, y, near, dx, dy, dnear, per_x, per_y;
    wholes ahead_x, ahead_y; /* 1: to greater places */
    wholes at_x, at_y, level, lit, active;
    reals u;
} line_set;

#define CHOOSE(mask, a, b) (((a) & (mask)) | ((b) & ~(mask)))
#define CHOOSE_REAL(mask, a, b) ((reals)CHOOSE(mask, (wholes)(a), (wholes)(b)))
#define LEAST(a, b) CHOOSE_REAL((a) < (b), a, b)
#define MOST(a, b) CHOOSE_REAL((a) > (b), a, b)
#define TO_WHOLE(a) __builtin_convertvector(a, wholes)
#define TO_REAL(a) __builtin_convertvector(a, reals)

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

/* Compilers take gathers apart, which takes longer than all the rest. */
TY_INLINE void gather(const float* from, const wholes* places, reals* out) {
#if defined(__AVX512F__)
    *out = (reals)_mm512_i32gather_ps((__m512i)*places, from, sizeof(float));
#else
    for (int32_t i = 0; i < LINES; ++i) (*out)[i] = from[(*places)[i]];
#endif
}

TY_INLINE bool any(const wholes* mask) {
#if defined(__AVX512F__)
    return _mm512_test_epi32_mask((__m512i)*mask, (__m512i)*mask) != 0;
#else
    int32_t sum = 0;
    for (int32_t i = 0; i < LINES; ++i) sum |= (*mask)[i];
    return sum != 0;
#endif
}

/* What changes within blocks: lines that turn dark or lit, one by one. */
TY_INLINE void turn(const ty_lit_line* lines, const wholes* turns, const wholes* before, const reals* node,
                    const reals* leave, line_set* set, ty_lit_run* runs) {
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
    wholes offsets = {0}, widths = {0};
    begin(lines, count, side, top, runs, &set);
    for (int32_t i = 0; i <= top; ++i) {
        offsets[i] = (int32_t)face->offset[i];
        widths[i] = (side + (1 << i) - 1) >> i;
    }
    while (any(&set.active)) {
        const wholes level = set.level, coarse = (level > 0) & 1;
        const wholes block_x = set.at_x >> level, block_y = set.at_y >> level;
        const wholes edge_x = (block_x + set.ahead_x) << level, edge_y = (block_y + set.ahead_y) << level;
        const reals u_x = (TO_REAL(edge_x) - set.x) * set.per_x, u_y = (TO_REAL(edge_y) - set.y) * set.per_y;
        const reals first = LEAST(u_x, u_y), capped = CHOOSE_REAL(first < 1.0f, first, (reals){0} + 1.0f);
        const reals leave = MOST(set.u, capped);
        const wholes place = (block_y * __builtin_shuffle(widths, level) + block_x) << coarse;
        const wholes node = (__builtin_shuffle(offsets, level) + place) & set.active;
        const wholes node_high = node + (coarse & set.active);
        reals low, high;
        gather(face->nodes, &node, &low);
        gather(face->nodes, &node_high, &high);
        const reals here = set.near + set.u * set.dnear, there = set.near + leave * set.dnear;
        const wholes before = LEAST(here, there) >= high, behind = MOST(here, there) < low;
        const wholes unsure = ~(before | behind), fine = level == 0;
        const wholes descends = unsure & ~fine & set.active, stays = set.active & ~descends;
        const wholes turns = stays & ((unsure & fine) | ((before & 1) != set.lit));
        if (any(&turns)) turn(lines, &turns, &before, &low, &leave, &set, runs);
        const wholes by_x = u_x < u_y, last = (1 << level) - 1;
        const wholes low_x = block_x << level, low_y = block_y << level;
        const wholes slid_x = TO_WHOLE(set.x + leave * set.dx), slid_y = TO_WHOLE(set.y + leave * set.dy);
        const wholes kept_x = CHOOSE(slid_x < low_x, low_x, CHOOSE(slid_x > low_x + last, low_x + last, slid_x));
        const wholes kept_y = CHOOSE(slid_y < low_y, low_y, CHOOSE(slid_y > low_y + last, low_y + last, slid_y));
        const wholes next_x = CHOOSE(by_x, edge_x - (1 - set.ahead_x), kept_x);
        const wholes next_y = CHOOSE(by_x, kept_y, edge_y - (1 - set.ahead_y));
        const wholes ends = (leave >= 1.0f) | (next_x < 0) | (next_y < 0) | (next_x >= side) | (next_y >= side);
        const wholes even = (CHOOSE(by_x, block_x, block_y) & 1) == CHOOSE(by_x, set.ahead_x, set.ahead_y);
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

const ty_lit_kernels TY_JOIN(ty_lit_kernels_, TY_ISA) = {.walk = walk};
