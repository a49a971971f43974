/* Where the cells of an ordinate's grid lie: boxes along its direction, or shells about its point. */
#ifndef TY_METHOD_POP_FRAME_K_H
#define TY_METHOD_POP_FRAME_K_H

#include "method/pop/ordinate.h"

/* Cells i, j, k: light travels with k. Parallel: boxes along three axes at right angles. Radial: i and j are
 * coordinates of an octahedral map, whose edges are joined to themselves; shells k grow by a constant factor. */
typedef struct ty_pop_frame {
    int32_t kind;    /* TY_POP_PARALLEL, TY_POP_RADIAL */
    int32_t size[3]; /* radial: size[0] is size[1] */
    ty_vec axis[3];  /* parallel: unit; axis[2] is the ordinate's direction */
    ty_vec origin;   /* parallel: the corner of cell 0, 0, 0; radial: the point; m */
    ty_vec step;     /* parallel: edges of cells, m */
    float inner;     /* radial: radius at which shell 0 begins, m */
    float growth;    /* radial: natural logarithm of the ratio of radii of shells */
} ty_pop_frame;

#endif
