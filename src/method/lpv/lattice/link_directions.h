/* The links of a cell to its neighbours. */
#ifndef TY_METHOD_LPV_LATTICE_LINK_DIRECTIONS_H
#define TY_METHOD_LPV_LATTICE_LINK_DIRECTIONS_H

#include <stdint.h>

enum { TY_LPV_LINKS = 26, TY_LPV_HALF_LINKS = 13 };

/* The index of the link along (dx, dy, dz), each -1, 0 or 1 and not all 0. Link k + 13 is opposite to link k < 13. */
static inline int32_t ty_lpv_link(int32_t dx, int32_t dy, int32_t dz) {
    const int32_t place = (dx + 1) + 3 * (dy + 1) + 9 * (dz + 1);
    return place < TY_LPV_HALF_LINKS ? place : 3 * TY_LPV_HALF_LINKS - place;
}
/* The direction of a link: the inverse of ty_lpv_link. */
static inline void ty_lpv_link_step(int32_t link, int32_t step[3]) {
    const int32_t place = link < TY_LPV_HALF_LINKS ? link : 3 * TY_LPV_HALF_LINKS - link;
    step[0] = place % 3 - 1;
    step[1] = place / 3 % 3 - 1;
    step[2] = place / 9 - 1;
}

#endif
