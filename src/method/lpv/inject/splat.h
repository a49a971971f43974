/* Light that lands in cells, added up in an order that does not depend on the number of threads. */
#ifndef TY_METHOD_LPV_SPLAT_H
#define TY_METHOD_LPV_SPLAT_H

#include "method/lpv/lattice/lattice.h"

/* A lobe of light in a cell. */
typedef struct ty_splat {
    int32_t cell;
    int32_t slab;   /* found by ty_splats_add */
    float power[3]; /* W */
    ty_vec axis;    /* unit */
} ty_splat;

/* Rows of at most `most` splats each. */
typedef struct ty_splat_rows {
    int64_t rows;
    int32_t most;
    const void* user;
    int32_t (*row)(const void* user, int64_t row, ty_splat* out); /* any thread; returns how many */
    float band[TY_LPV_BANDS_MAX];                                 /* of the lobes about axes; the first is 1 */
    bool turned; /* whether band l is also times g^l of the lattice's medium */
} ty_splat_rows;

/* Adds them to what flows, and to power, W per channel. Errors: TY_ERROR_MEMORY. */
ty_result ty_splats_add(ty_lattice* lattice, const ty_splat_rows* rows, double power[3]);

/* Where cells are, for many points. */
typedef struct ty_splat_cells {
    float lower[3], per_cell; /* m, 1/m */
    int32_t size[3];
} ty_splat_cells;

static inline ty_splat_cells ty_splat_cells_of(const ty_lattice* lattice) {
    ty_splat_cells out = {.per_cell = 1.0f / lattice->cell};
    for (int a = 0; a < 3; ++a) {
        out.lower[a] = (float)lattice->box.lower[a];
        out.size[a] = lattice->box.size[a];
    }
    return out;
}

/* The cell that a point is in; -1 outside of the lattice. */
static inline int32_t ty_splat_cell(const ty_splat_cells* cells, ty_vec point) {
    const float x = (point.x - cells->lower[0]) * cells->per_cell, y = (point.y - cells->lower[1]) * cells->per_cell;
    const float z = (point.z - cells->lower[2]) * cells->per_cell;
    const bool inside = x >= 0.0f && y >= 0.0f && z >= 0.0f && x < (float)cells->size[0] && y < (float)cells->size[1] &&
                        z < (float)cells->size[2];
    return inside ? (int32_t)x + cells->size[0] * ((int32_t)y + cells->size[1] * (int32_t)z) : -1;
}

/* How far off a surface (unit normal) a point is to be for its cell's middle to be on the same side, m. */
static inline float ty_splat_clearance(const ty_lattice* lattice, ty_vec normal) {
    return 0.5f * lattice->cell * (fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z));
}

#endif
