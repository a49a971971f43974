/* All links of one direction, in their places: those that lead out of the lattice, too. */
#ifndef TY_METHOD_LPV_LINKS_H
#define TY_METHOD_LPV_LINKS_H

#include "method/lpv/lattice/lattice.h"

#include <stdlib.h>

typedef struct ty_link_grid {
    int32_t step[3];
    int32_t size[3]; /* places: the lattice's, and one more along axes that the step goes along */
    size_t count;
} ty_link_grid;

static inline ty_link_grid ty_link_grid_of(const ty_lattice* lattice, int32_t link) {
    ty_link_grid out;
    ty_lpv_link_step(link, out.step);
    for (int a = 0; a < 3; ++a) out.size[a] = lattice->box.size[a] + abs(out.step[a]);
    out.count = (size_t)out.size[0] * (size_t)out.size[1] * (size_t)out.size[2];
    return out;
}

static inline size_t ty_link_at(const ty_link_grid* grid, const int32_t place[3]) {
    const size_t row = (size_t)place[1] + (size_t)grid->size[1] * (size_t)place[2];
    return (size_t)place[0] + (size_t)grid->size[0] * row;
}

/* The place of the link before (way -1) or after (1) in a row; false where there is none. */
static inline bool ty_link_next(const ty_link_grid* grid, const int32_t place[3], int32_t way, int32_t next[3]) {
    for (int a = 0; a < 3; ++a) {
        next[a] = place[a] + way * grid->step[a];
        if (next[a] < 0 || next[a] >= grid->size[a]) return false;
    }
    return true;
}

/* The cells that a link is between. */
static inline void ty_link_ends(const ty_link_grid* grid, const int32_t place[3], int32_t from[3], int32_t to[3]) {
    for (int a = 0; a < 3; ++a) {
        from[a] = place[a] - (grid->step[a] > 0 ? 1 : 0);
        to[a] = from[a] + grid->step[a];
    }
}

/* The cell's number; false outside of the lattice. */
static inline bool ty_link_cell(const ty_lattice* lattice, const int32_t cell[3], size_t* index) {
    const int32_t* size = lattice->box.size;
    for (int a = 0; a < 3; ++a)
        if (cell[a] < 0 || cell[a] >= size[a]) return false;
    *index = (size_t)cell[0] + (size_t)size[0] * ((size_t)cell[1] + (size_t)size[1] * (size_t)cell[2]);
    return true;
}

/* Opens a link both ways. */
static inline void ty_link_set(ty_lattice* lattice, int32_t link, const ty_link_grid* grid, const int32_t place[3],
                               uint8_t transmission) {
    int32_t from[3], to[3];
    size_t index;
    ty_link_ends(grid, place, from, to);
    if (ty_link_cell(lattice, to, &index)) lattice->transmission[link][index] = transmission;
    if (ty_link_cell(lattice, from, &index)) lattice->transmission[link + TY_LPV_HALF_LINKS][index] = transmission;
}

#endif
