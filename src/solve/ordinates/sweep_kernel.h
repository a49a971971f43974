/* Sweep of a block of cells along the directions of two octants. Compiled once per instruction set. */
#ifndef TY_SOLVE_ORDINATES_SWEEP_KERNEL_H
#define TY_SOLVE_ORDINATES_SWEEP_KERNEL_H

#include "base/dispatch.h"
#include "solve/ordinates/sweep.h"

/* Data shared by all blocks. Directions of an octant are grouped by SIMD lanes, the last group padded with directions
 * of zero weight; the octants are mirror images of each other. Bits 0 to 2 of an octant's number: its directions are
 * negative along x, y and z. */
typedef struct ty_sweep_box {
    int32_t size[3];
    int32_t lanes, groups, directions; /* directions: per octant */
    int32_t terms;                     /* number of harmonics */
    int32_t even;                      /* number of harmonics with even parity in x */
    int32_t padded;                    /* both parities, each padded to whole lanes */
    const int32_t* order;              /* terms, even parity first */
    const int32_t* position;           /* position of each term in `order`; padded to whole lanes with -1 */
    const float* extinction;
    const float* two_mu_over_h[3];          /* 2 |mu| / h per direction, 1/m */
    const float* partial_current_weight[3]; /* per direction and face across each axis: W per unit of radiance */
    const float* y_lm[4];                   /* octant 2 i: all directions of each term in `order` */
    /* Incident radiance of each direction of an octant through each patch of the face across each axis. */
    const float* boundary_radiance[3][8];
    ty_boundary_radiance patches;  /* their numbers */
    const float* weighted_y_lm[4]; /* octant 2 i: weighted harmonics of each direction, `padded` in `order` */
    const float* unpaired_y_lm[8]; /* weighted harmonics of each direction of an octant that is swept alone,
                                      `unpaired` in `order`; NULL: none is */
    int32_t unpaired_terms;        /* terms, padded to whole lanes */
    /* Upwind radiance of the next cells along y and z: per group, planes of x and z, and of x and y. */
    float *faces_y[8], *faces_z[8];
    /* Of octants that are swept alone, radiance across x at the ends of rows: what enters, and then what leaves; per
     * group, a plane of y and z. Of boxes that repeat along x, what leaves. */
    float* faces_x[8];
    uint32_t periodic; /* axes along which the box repeats, as a mask */
    /* Power that passes through the faces of cells across an axis, towards lower and upper cells: of each cell, through
     * its downwind face, W; NULL: not asked for. */
    float* passing[2];
    int32_t passing_axis;        /* y or z */
    int32_t whole[3], origin[3]; /* cells of the box of which this one is a part, and the place of its first cell */
    const ty_sweep_faces* walls; /* NULL: no boundary faces */
    const uint16_t* closed;      /* as of ty_sweep_set_closed */
} ty_sweep_box;

/* The tables of a sweep. */
const ty_sweep_box* ty_sweep_tables(const ty_sweep* sweep);

/* Block of rows for a pair of octants that differ in x only: 2 * pair and 2 * pair + 1. */
typedef struct ty_sweep_block {
    int32_t pair;
    int32_t unpaired;         /* bit 0 of the octant that is swept alone, and no pair; negative: both are */
    bool leaves;              /* alone: the ends of its rows are faces of the whole box */
    int32_t begin[2], end[2]; /* y, z */
    bool first, last;         /* this pair is the first, the last of four to sweep the block */
} ty_sweep_block;

typedef struct ty_sweep_sums {
    double leaving; /* through faces at the ends of rows, W */
    int64_t fixups; /* cells and directions with a set-to-zero fix-up */
} ty_sweep_sums;

typedef struct ty_sweep_kernels {
    int32_t lanes;
    /* Floats of scratch memory, initially 0, for one thread at a time. */
    size_t (*scratch)(const ty_sweep_box* box);
    /* Adds to sums, and to moments, which the first pair initialises; their terms are in `order` until the last pair is
     * done. */
    void (*cross)(const ty_sweep_box* box, const ty_sweep_block* block, const float* emission, float* moments,
                  float* scratch, ty_sweep_sums* sums);
} ty_sweep_kernels;
TY_DECLARE_KERNELS(ty_sweep_kernels);

#endif
