/* The order in which ranks that own columns of a box sweep it (Koch, Baker and Alcouffe 1992; Baker and Koch 1998).
 *
 * The box is cut along x and y; each rank has all of z, in blocks of planes. A unit of work is a block of planes along
 * a stream of directions: an octant, or, where the box is not cut along x, two octants that differ in x alone. A unit
 * can begin when those upwind of it are done: of the same block at the neighbours along x and y, and of the block
 * before it. Of several units a rank takes that of the stream with most ranks downwind (Adams et al. 2013); so all
 * corners of the box begin at once. */
#ifndef TY_SOLVE_ORDINATES_SWEEP_SCHEDULE_H
#define TY_SOLVE_ORDINATES_SWEEP_SCHEDULE_H

#include <tyndall/base.h>

enum { TY_SWEEP_STREAMS_MAX = 8 };

typedef struct ty_sweep_unit {
    int16_t stream;   /* octant, or pair of octants: bits 0 and 1 for y and z */
    int16_t block;    /* of planes, from the lowest z on */
    bool first, last; /* of the streams to sweep this block */
} ty_sweep_unit;

typedef struct ty_sweep_schedule {
    int32_t streams, blocks; /* 8 octants or 4 pairs; blocks of planes */
    int32_t planes;          /* of a block; the last one may have fewer */
    int64_t stages;          /* units of time until all ranks are done, where each unit takes one */
    int32_t count;           /* of units of each rank: streams * blocks */
    ty_sweep_unit* units;    /* of one rank, in its order; NULL: not asked for */
} ty_sweep_schedule;

/* Streams and blocks of planes for ranks along x and y, such that ranks wait for about a tenth of the time. */
ty_sweep_schedule ty_sweep_choose_blocks(const int32_t parts[2], int32_t planes);
/* Fills in `stages`, and the units of the rank at a place. Errors: TY_ERROR_MEMORY. */
ty_result ty_sweep_schedule_make(ty_context* context, const int32_t parts[2], const int32_t at[2],
                                 ty_sweep_schedule* schedule);
void ty_sweep_schedule_free(ty_context* context, ty_sweep_schedule* schedule);

#endif
