/* The grid of all links of one direction, including those that leave the lattice. */
#ifndef TY_METHOD_LPV_LATTICE_LINKS_H
#define TY_METHOD_LPV_LATTICE_LINKS_H

#include "method/lpv/lattice/lattice.h"

#include <stdlib.h>

typedef struct ty_link_grid {
    int32_t step[3];
    int32_t size[3]; /* links per axis: one more than cells along the axes of the step */
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

/* The previous (way -1) or next (1) link in a row; false if there is none. */
static inline bool ty_link_next(const ty_link_grid* grid, const int32_t place[3], int32_t sign, int32_t next[3]) {
    for (int a = 0; a < 3; ++a) {
        next[a] = place[a] + sign * grid->step[a];
        if (next[a] < 0 || next[a] >= grid->size[a]) return false;
    }
    return true;
}

/* The two cells that a link connects. */
static inline void ty_link_ends(const ty_link_grid* grid, const int32_t place[3], int32_t from[3], int32_t to[3]) {
    for (int a = 0; a < 3; ++a) {
        from[a] = place[a] - (grid->step[a] > 0 ? 1 : 0);
        to[a] = from[a] + grid->step[a];
    }
}

/* The index of a cell; false outside the lattice. */
static inline bool ty_link_cell(const ty_lattice* lattice, const int32_t cell[3], size_t* index) {
    const int32_t* size = lattice->box.size;
    for (int a = 0; a < 3; ++a)
        if (cell[a] < 0 || cell[a] >= size[a]) return false;
    *index = (size_t)cell[0] + (size_t)size[0] * ((size_t)cell[1] + (size_t)size[1] * (size_t)cell[2]);
    return true;
}

/* Sets the transmission of a link in both directions. */
static inline void ty_link_set(ty_lattice* lattice, int32_t link, const ty_link_grid* grid, const int32_t place[3],
                               uint8_t transmission) {
    int32_t from[3], to[3];
    size_t index;
    ty_link_ends(grid, place, from, to);
    if (ty_link_cell(lattice, to, &index)) lattice->transmission[link][index] = transmission;
    if (ty_link_cell(lattice, from, &index)) lattice->transmission[link + TY_LPV_HALF_LINKS][index] = transmission;
}

#endif
