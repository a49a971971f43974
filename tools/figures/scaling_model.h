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

typedef struct scaling_sweep {
    int32_t cells[3]; /* divided in i and j */
    int32_t directions;
    double cell_seconds;  /* of one cell and direction */
    double octant_factor; /* times as long where the box is cut along i: octants that differ in x alone are then swept
                             apart */
} scaling_sweep;

/* The work of a rank in a sweep, by ty_ordinates_plan_ranks or by the published KBA. */
typedef struct scaling_stages {
    int32_t ranks[2];       /* along i and j */
    double units, stages;   /* blocks of work, and stages until all ranks have done theirs */
    double messages, bytes; /* that it sends to its neighbours downstream */
} scaling_stages;

/* The division into columns whose faces are smallest, at most one column of cells each; their number is at most
 * `ranks`. */
void scaling_divide(const int32_t cells[3], int32_t ranks, int32_t counts[2]);
/* The published KBA with so many planes of an octant in a block, and with those, a power of two, that take the least
 * time. */
scaling_stages scaling_kba(const scaling_sweep* sweep, int32_t ranks, int32_t planes);
scaling_stages scaling_best_kba(const scaling_sweep* sweep, const scaling_network* network, int32_t ranks);
/* Seconds of a sweep: stages (block + messages of a block). */
double scaling_sweep_seconds(const scaling_sweep* sweep, const scaling_network* network, const scaling_stages* stages);

/* ---- Multigrid with halos ---- */

/* The work of a rank in a cycle, by ty_diffusion_plan_ranks. */
typedef struct scaling_cycle {
    double cells, messages, bytes;
} scaling_cycle;

/* Seconds of a cycle. */
double scaling_cycle_seconds(const scaling_cycle* cycle, const scaling_network* network, double cell_seconds);

#endif
