/* One sweep: light along all directions of a set through a box of cells, for sources that are known.
 *
 * Diamond differences: a cell's radiance is the mean of that of opposite faces. Where a face would fall below 0 it is
 * 0, and the cell balances without it; nowhere else does this change anything. What is emitted is absorbed or leaves,
 * to rounding, whatever the cells' thickness; where light changes little from cell to cell, as deep in thick media,
 * that holds for cells of any thickness, and elsewhere the error falls with the square of the cells' edges.
 *
 * Rows along y and z lie in blocks; those that wait for no others are gone through at once, the rest later. What is in
 * a block when does not depend on the number of threads, nor does any sum. */
#ifndef TY_SOLVE_ORDINATES_SWEEP_H
#define TY_SOLVE_ORDINATES_SWEEP_H

#include "solve/ordinates/ordinates.h"

/* What sweeps of one box share. Planes belong to the caller and outlive it. */
typedef struct ty_sweep ty_sweep;

/* extinction: sigma*, scaled already, at least 0. bands: of the sources' and the moments' harmonics. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_sweep_create(ty_context* context, const int32_t size[3], const double cell[3], const ty_angular_quadrature* set,
                          int32_t bands, const float* extinction, ty_sweep** out);
/* Lets light in through the box's faces: radiance of each direction of the set, the same all over them. NULL (as
 * created): none comes in. */
void ty_sweep_set_boundary_radiance(ty_sweep* sweep, const float* radiance);

/* Walls: faces of cells, between two of them or the box's own, that no light goes through. Each cell at one has a side
 * of it. All sides of a row of cells along x lie after one another, in the cells' order. */
typedef struct ty_sweep_faces {
    int32_t count;        /* of sides */
    const int32_t* first; /* of each row, y + size[1] * z; one more: count */
    const int32_t* x;     /* the cell that a side is of */
    const uint8_t* face;  /* which of its faces: 2 * axis, and 1 more for the upper one */
    const float* sent;    /* radiance that a side sends, the same in all directions into its cell */
    const float* tilt;    /* and with their cosines: times half a cell's edge along the face's axis; NULL: none */
    float* arrived;       /* W that arrive on it; sweeps replace them */
} ty_sweep_faces;

/* The struct, and its arrays, are the caller's, who may write to `sent` between sweeps. NULL (as created): none. */
void ty_sweep_set_faces(ty_sweep* sweep, const ty_sweep_faces* walls);
void ty_sweep_destroy(ty_sweep* sweep);
/* Bytes it holds. */
size_t ty_sweep_bytes(const ty_sweep* sweep);
/* Floating-point operations that a cell takes for each direction, at least: emission out of the harmonics and moments
 * into them, and what is between. */
double ty_sweep_operations(int32_t bands);

/* emission and moments: interleaved, bands^2 of each cell after one another, cells x fastest (what one cell needs lies
 * together). moments are replaced by the integrals of psi Y_lm that emission (of psi per metre) leaves; psi is that of
 * cells' middles, or means, as the scheme has it. leaving: what leaves through the faces, W; may be NULL. fixed: in how
 * many cells and directions, of all, the scheme had to keep radiance from falling below 0; may be NULL. */
ty_result ty_sweep_run(ty_sweep* sweep, const float* emission, float* moments, double* leaving, double* fixed);

#endif
