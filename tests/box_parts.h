/* Parts of a box of cells that is cut among ranks: their rows, and closed sides of their cells. */
#ifndef TY_TESTS_BOX_PARTS_H
#define TY_TESTS_BOX_PARTS_H

#include "comm/domain.h"

#include <stdlib.h>
#include <string.h>

static inline void size_of_part(const ty_domain* d, int32_t size[3]) {
    for (int a = 0; a < 3; ++a) size[a] = d->end[a] - d->first[a];
}

/* Copies rows of cells between a part and the whole, `terms` floats a cell; out: to the whole. */
static inline void copy_part(const int32_t whole[3], const ty_domain* d, size_t terms, float* all, float* part,
                             bool out) {
    const size_t nx = (size_t)(d->end[0] - d->first[0]);
    for (int32_t z = d->first[2]; z < d->end[2]; ++z)
        for (int32_t y = d->first[1]; y < d->end[1]; ++y, part += nx * terms) {
            float* row = all + ((size_t)d->first[0] + (size_t)whole[0] * (size_t)(y + whole[1] * z)) * terms;
            memcpy(out ? row : part, out ? part : row, nx * terms * sizeof(float));
        }
}

/* Sides of a part, as in ty_sweep_faces. */
typedef struct part_sides {
    int32_t *first, *x, count;
    int32_t* global; /* 6 * cell of the whole + face */
    uint8_t* face;
    float *given[2], *found; /* a number of each side, for and from a solver */
} part_sides;

static inline bool closes_above(const int32_t whole[3], int32_t period, const int32_t at[3], int axis) {
    const int32_t i = at[0] + whole[0] * (at[1] + whole[1] * at[2]);
    return period != 0 && i % period == 3 && axis == i % 3;
}

static inline bool has_side(const int32_t whole[3], int32_t period, const int32_t at[3], int face) {
    int32_t below[3] = {at[0], at[1], at[2]};
    if ((face & 1) != 0) return closes_above(whole, period, at, face / 2);
    return --below[face / 2] >= 0 && closes_above(whole, period, below, face / 2);
}

/* One cell of the whole in `period` is closed towards its upper neighbour along an axis, and that towards it; 0: none.
 */
static inline part_sides make_sides(const int32_t whole[3], const ty_domain* d, int32_t period) {
    int32_t size[3];
    size_of_part(d, size);
    const size_t rows = (size_t)size[1] * (size_t)size[2], most = rows * (size_t)size[0] * 6;
    part_sides s = {.first = calloc(rows + 1, sizeof(int32_t)),
                    .x = calloc(most, sizeof(int32_t)),
                    .global = calloc(most, sizeof(int32_t)),
                    .face = calloc(most, 1),
                    .given = {calloc(most, sizeof(float)), calloc(most, sizeof(float))},
                    .found = calloc(most, sizeof(float))};
    for (int32_t row = 0; row < (int32_t)rows; ++row) {
        s.first[row] = s.count;
        for (int32_t x = 0; x < size[0]; ++x)
            for (int face = 0; face < 6; ++face) {
                const int32_t at[3] = {d->first[0] + x, d->first[1] + row % size[1], d->first[2] + row / size[1]};
                if (!has_side(whole, period, at, face)) continue;
                s.x[s.count] = x;
                s.face[s.count] = (uint8_t)face;
                s.global[s.count++] = 6 * (at[0] + whole[0] * (at[1] + whole[1] * at[2])) + face;
            }
    }
    s.first[rows] = s.count;
    return s;
}

static inline void free_sides(part_sides* s) {
    free(s->first);
    free(s->x);
    free(s->global);
    free(s->face);
    free(s->given[0]);
    free(s->given[1]);
    free(s->found);
}

#endif
