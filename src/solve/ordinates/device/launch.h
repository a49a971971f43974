/* Arguments of the programs of sweeps on a device. */
#ifndef TY_SOLVE_ORDINATES_DEVICE_LAUNCH_H
#define TY_SOLVE_ORDINATES_DEVICE_LAUNCH_H

#include "base/kernel.h"
#include "device/program.h"

/* One plane of the wavefront in all octants: the cells at whose places, counted from the corner where an octant's
 * directions begin, i + j + k = plane. A column has the cells of one y and z; each has at most one cell in a plane.
 * Octants and tables are those of ty_sweep_box. All arrays are in the device's memory. */
typedef struct ty_ordinates_launch {
    int32_t size[3], plane;
    int32_t directions, terms, bands; /* directions: per octant */
    int32_t even, odd_begin; /* number of even terms, and place of the first odd one in a row of weighted_y_lm */
    int32_t pitch, padded;   /* floats from one term of y_lm, one direction of weighted_y_lm, to the next */
    TY_GLOBAL const int32_t* order;
    TY_GLOBAL const float* two_mu_over_h[3];
    TY_GLOBAL const float* y_lm[4];
    TY_GLOBAL const float* weighted_y_lm[4];
    TY_GLOBAL const float* extinction;
    TY_GLOBAL const float* emission;
    TY_GLOBAL float* faces[3]; /* radiance at the faces across each axis that the planes have reached: octant by octant,
                                  the face's cells, and of each all directions */
    TY_GLOBAL float* psi;      /* mean radiance of the plane's cells, in the order of the faces across x */
    TY_GLOBAL float* moments;  /* sums, at first 0 */
    TY_GLOBAL uint32_t* fixups; /* by item; NULL: not counted */
} ty_ordinates_launch;

/* A direction in a cell of the plane: items are directions, within columns, within octants; and then a moment of a
 * cell: items are terms, within columns, within octants. */
extern const ty_program ty_program_ordinates_sweep, ty_program_ordinates_moments;

#endif
