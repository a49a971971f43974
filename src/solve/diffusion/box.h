/* Memory layout of a box of cells: one layer of ghosts, rows padded to an even length. */
#ifndef TY_SOLVE_DIFFUSION_BOX_H
#define TY_SOLVE_DIFFUSION_BOX_H

#include "solve/diffusion/diffusion.h"

typedef struct ty_box {
    int32_t size[3];
    ptrdiff_t row, plane;       /* stride between rows, and between planes */
    int32_t dense_rows;         /* rows of a plane in arrays without ghosts */
    int32_t whole[3], first[3]; /* cells of the grid of which it is a rank's part, and its first cell there */
    int32_t ratio[3];           /* cells of the finest grid per cell */
    uint32_t cut;               /* sides beyond which other ranks have cells, as a mask; 0: the whole grid */
} ty_box;

/* A whole grid of its own. */
static inline ty_box ty_box_make(int32_t nx, int32_t ny, int32_t nz) {
    const ptrdiff_t row = ((ptrdiff_t)nx + 2 + 1) / 2 * 2;
    return (ty_box){.size = {nx, ny, nz},
                    .row = row,
                    .plane = row * (ny + 2),
                    .dense_rows = ny,
                    .whole = {nx, ny, nz},
                    .ratio = {1, 1, 1}};
}

/* True if a side of the box is one of the grid. */
static inline bool ty_box_ends(const ty_box* box, int side) {
    return (box->cut >> side & 1) == 0;
}

/* Number of items of an array, and the offset of cell (0, 0, 0). */
static inline size_t ty_box_items(const ty_box* box) {
    return (size_t)(box->plane * (box->size[2] + 2) + 16);
}

static inline ptrdiff_t ty_box_origin(const ty_box* box) {
    return box->plane + box->row + 8;
}

static inline ptrdiff_t ty_box_at(const ty_box* box, int32_t y, int32_t z) {
    return box->row * y + box->plane * z;
}

/* Offset of a row in arrays without ghosts. */
static inline ptrdiff_t ty_box_dense(const ty_box* box, int32_t y, int32_t z) {
    return ((ptrdiff_t)z * box->dense_rows + y) * box->size[0];
}

static inline int64_t ty_box_cells(const ty_box* box) {
    return (int64_t)box->size[0] * box->size[1] * box->size[2];
}

/* Cells of the grid. */
static inline int64_t ty_box_whole_cells(const ty_box* box) {
    return (int64_t)box->whole[0] * box->whole[1] * box->whole[2];
}

#endif
