/* Which of the eight cells about a point are on its own side of the surfaces between them. */
#ifndef TY_IMAGE_CUTS_K_H
#define TY_IMAGE_CUTS_K_H

#include "base/vector.k.h"

enum { TY_CUT_PLANES = 3, TY_CUT_SIDES = 1 << TY_CUT_PLANES };

/* Surfaces between eight cells. */
typedef struct ty_cell_cut {
    float plane[TY_CUT_PLANES][4]; /* x, y, z and offset, in cells: below 0 behind it; all 0 where there are fewer */
    uint8_t joined[TY_CUT_SIDES];  /* by the planes a point is behind, a bit each: the cells that its light comes from,
                                      x fastest */
    uint8_t parts[8];              /* by one of the eight: those that open faces join it to, and itself */
} ty_cell_cut;

typedef struct ty_cuts_view {
    TY_GLOBAL const int32_t* of_cell; /* by the lowest of the eight cells: their cut, -1 for none; NULL: no cuts */
    TY_GLOBAL const ty_cell_cut* cuts;
} ty_cuts_view;

/* Smallest weight of a cell on a point's side, so that a point that is farther off than all of them has their
 * mean. */
#define TY_CUT_LEAST 1e-6f

/* Takes their weights from cells that a point, in cells, is not joined to, and makes the rest 1 in all. base: the
 * lowest of the eight. */
TY_FN void ty_cuts_weigh(const ty_cuts_view* view, size_t base, ty_vec cells, float weight[8]) {
    const int32_t index = view->of_cell[base];
    if (index < 0) return;
    TY_GLOBAL const ty_cell_cut* cut = &view->cuts[index];
    uint32_t side = 0;
    for (uint32_t i = 0; i < TY_CUT_PLANES; ++i) {
        TY_GLOBAL const float* plane = cut->plane[i];
        const float off = plane[0] * cells.x + plane[1] * cells.y + plane[2] * cells.z + plane[3];
        side |= off < 0.0f ? 1u << i : 0u;
    }
    const uint32_t joined = cut->joined[side];
    float sum = 0.0f;
    for (int i = 0; i < 8; ++i) {
        weight[i] = (joined >> i & 1u) != 0 ? weight[i] + TY_CUT_LEAST : 0.0f;
        sum += weight[i];
    }
    const float scale = 1.0f / sum;
    for (int i = 0; i < 8; ++i) weight[i] *= scale;
}

#endif
