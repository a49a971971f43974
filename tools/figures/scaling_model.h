/* A model of the time of one command by 1 to thousands of ranks, from measured compute and counted messages. Each rank
 * has a core of its own, and all cores are as fast as the one that was measured. */
#ifndef TY_FIGURES_SCALING_MODEL_H
#define TY_FIGURES_SCALING_MODEL_H

#include <stdint.h>

typedef struct scaling_network {
    double latency;   /* s */
    double bandwidth; /* bytes/s */
} scaling_network;

/* Seconds of a message: latency + bytes / bandwidth. */
double scaling_message(const scaling_network* network, double bytes);

/* ---- Tasks of rank 0 (docs/farm.md) ---- */

typedef struct scaling_tasks {
    double start;   /* s that every rank needs before and after its tasks: MPI, the scene, what all ranks make */
    double work;    /* s of all blocks on one core */
    double task;    /* s of a task; the last ones end half of one apart */
    double bytes;   /* that rank 0 sends and receives, for any number of ranks above 1 */
    int64_t blocks; /* of which no two ranks share one */
} scaling_tasks;

double scaling_tasks_seconds(const scaling_tasks* tasks, const scaling_network* network, int32_t ranks);

/* ---- Sweeps over columns: Koch, Baker and Alcouffe (1992) ---- */

typedef enum scaling_schedule {
    SCALING_KBA,    /* the pipeline is filled at each of the four corners: Baker & Koch (1998) */
    SCALING_MINIMAL /* fewest stages of any schedule: Adams et al. (2020) */
} scaling_schedule;

typedef struct scaling_sweep {
    int32_t cells[3];    /* divided in i and j */
    int32_t directions;  /* of all eight octants */
    int32_t planes;      /* of k in a block */
    int32_t group;       /* directions of an octant in a block */
    double cell_seconds; /* of one cell and direction */
    double face_bytes;   /* of one face and direction */
    scaling_schedule schedule;
    int32_t in_a_row;     /* up to so many ranks are cut along j alone */
    double octant_factor; /* times as long for a cell where the box is cut along i: octants that differ in x alone are
                     then swept apart */
} scaling_sweep;

/* The division into columns whose faces are smallest, at most one column of cells each; their number is at most
 * `ranks`. */
void scaling_divide(const int32_t cells[3], int32_t ranks, int32_t counts[2]);
/* The division of a sweep. */
void scaling_sweep_divide(const scaling_sweep* sweep, int32_t ranks, int32_t counts[2]);
/* Blocks of one rank, and the stages in which it has none. */
double scaling_sweep_blocks(const scaling_sweep* sweep);
double scaling_sweep_idle(const scaling_sweep* sweep, const int32_t counts[2]);
/* Planes of a block, a power of two, with which so many ranks take the least time. */
int32_t scaling_best_planes(const scaling_sweep* sweep, const scaling_network* network, int32_t ranks);
/* 1 / ((1 + idle / blocks) (1 + message / block)). */
double scaling_sweep_efficiency(const scaling_sweep* sweep, const scaling_network* network, int32_t ranks);
double scaling_sweep_seconds(const scaling_sweep* sweep, const scaling_network* network, int32_t ranks);

/* ---- Multigrid with halos ---- */

typedef struct scaling_multigrid {
    int32_t cells[3];      /* divided in i and j */
    double cycles;         /* of the whole solve */
    double cell_seconds;   /* of one cell of any level and cycle */
    double exchanges;      /* of halos on a level and cycle */
    double face_bytes;     /* of one face and exchange */
    double gathered_cells; /* levels of at most so many cells are solved by one rank */
    double cell_bytes;     /* of one gathered cell, there and back */
} scaling_multigrid;

/* Cells of all levels. */
double scaling_multigrid_cells(const scaling_multigrid* grid);
double scaling_multigrid_seconds(const scaling_multigrid* grid, const scaling_network* network, int32_t ranks);

/* ---- Memory ---- */

/* Bytes of a rank: of its cells, and of a layer of halo about its columns. */
double scaling_memory(const int32_t cells[3], double cell_bytes, double face_bytes, int32_t ranks);

#endif
