/* Light that lands in cells, added up in an order that does not depend on the number of threads. */
#ifndef TY_METHOD_LPV_SPLAT_H
#define TY_METHOD_LPV_SPLAT_H

#include "method/lpv/lattice.h"

/* A lobe of light in a cell. */
typedef struct ty_splat {
    int32_t cell;
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

/* The cell that a point is in; -1 outside of the lattice. */
int32_t ty_splat_cell(const ty_lattice* lattice, ty_vec point);

/* How far off a surface (unit normal) a point is to be for its cell's middle to be on the same side, m. */
float ty_splat_clearance(const ty_lattice* lattice, ty_vec normal);

#endif
