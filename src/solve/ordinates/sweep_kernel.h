/* Light through a block of cells along the directions of two octants, built once per instruction set. */
#ifndef TY_SOLVE_ORDINATES_SWEEP_KERNEL_H
#define TY_SOLVE_ORDINATES_SWEEP_KERNEL_H

#include "solve/ordinates/sweep.h"

/* Cells of a row that are worked on at once. */
enum { TY_SWEEP_CELLS = 8 };

/* What all blocks share. Directions of an octant lie in groups of as many as the kernel has lanes, the last of them
 * filled up with dark ones; those of all octants are each other's mirror images. An octant's number says in bits 0 to 2
 * whether its directions go down along x, y and z. */
typedef struct ty_sweep_box {
    int32_t size[3];
    int32_t lanes, groups, directions; /* directions: of an octant */
    int32_t terms;                     /* harmonics */
    int32_t even;                      /* of them, those that mirroring along x leaves as they are */
    int32_t padded;                    /* these, and the others, each filled up to whole lanes */
    const int32_t* order;              /* the terms, even ones first */
    const int32_t* place;              /* of each term in that order; filled up to whole lanes with -1 */
    const float* extinction;
    const float* two_mu_over_h[3];          /* 2 |cosine| / edge, 1/m, one for each direction */
    const float* partial_current_weight[3]; /* of faces along each axis: W for each unit of radiance */
    const float* y_lm[4];                   /* of octant 2 i: terms in `order`, of each all directions */
    const float*
        boundary_radiance[8];      /* radiance of an octant's each direction that comes in through the box's faces */
    const float* weighted_y_lm[4]; /* of octant 2 i, each direction: `padded` harmonics in `order` times its weight */
    /* Radiance that goes into the next cells along y and z: of each group planes of x and z, and of x and y. */
    float *faces_y[8], *faces_z[8];
    const ty_sweep_faces* walls; /* NULL: there are none */
} ty_sweep_box;

/* Rows of cells, which two octants that differ in x alone go through: 2 * pair and the next. */
typedef struct ty_sweep_block {
    int32_t pair;
    int32_t begin[2], end[2]; /* y, z */
    bool first, last;         /* of the pairs that go through */
} ty_sweep_block;

typedef struct ty_sweep_sums {
    double leaving; /* through the faces at the ends of rows, W */
    int64_t fixups; /* cells, of each direction, that had a face held at 0 */
} ty_sweep_sums;

typedef struct ty_sweep_kernels {
    int32_t lanes;
    /* Floats of scratch memory, which starts as zeros and belongs to one thread at a time. */
    size_t (*scratch)(const ty_sweep_box* box);
    /* Adds to sums, and to moments, which the first pair puts there; their terms are in `order` until the last did. */
    void (*cross)(const ty_sweep_box* box, const ty_sweep_block* block, const float* emission, float* moments,
                  float* scratch, ty_sweep_sums* sums);
} ty_sweep_kernels;

extern const ty_sweep_kernels ty_sweep_kernels_v1, ty_sweep_kernels_v3, ty_sweep_kernels_v4;

/* ty_sweep_create with kernels of one's choice, for tests. */
ty_result ty_sweep_create_with(ty_context* context, const ty_sweep_kernels* kernels, const int32_t size[3],
                               const double cell[3], const ty_angular_quadrature* set, int32_t bands,
                               const float* extinction, ty_sweep** out);

#endif
