#include "figures/scaling_model.h"

#include <math.h>

double scaling_message(const scaling_network* network, double bytes) {
    return network->latency + bytes / network->bandwidth;
}

/* ---- tasks of rank 0 ---- */

double scaling_tasks_seconds(const scaling_tasks* tasks, const scaling_network* network, int32_t ranks) {
    const double blocks = (double)tasks->blocks, share = ceil(blocks / ranks) / blocks;
    const double own = tasks->start + tasks->work * share;
    if (ranks < 2) return own;
    const double messages = 2 * (tasks->work / tasks->task + ranks);
    return own + 0.5 * tasks->task + messages * network->latency + tasks->bytes / network->bandwidth;
}

/* ---- sweeps ---- */

static int32_t min_int(int32_t a, int32_t b) {
    return a < b ? a : b;
}

/* Cells along an axis that the largest of `count` parts has. */
static int32_t part(int32_t cells, int32_t count) {
    return (cells + count - 1) / count;
}

void scaling_divide(const int32_t cells[3], int32_t ranks, int32_t counts[2]) {
    int32_t best = 0, best_faces = 0;
    counts[0] = counts[1] = 1;
    for (int32_t x = 1; x <= min_int(ranks, cells[0]); ++x) {
        const int32_t y = min_int(ranks / x, cells[1]), faces = part(cells[0], x) + part(cells[1], y);
        if (x * y < best || (x * y == best && faces >= best_faces)) continue;
        best = x * y;
        best_faces = faces;
        counts[0] = x;
        counts[1] = y;
    }
}

static double octant_group(const scaling_sweep* sweep) {
    return fmin(sweep->group, sweep->directions / 8.0);
}

void scaling_sweep_divide(const scaling_sweep* sweep, int32_t ranks, int32_t counts[2]) {
    counts[0] = 1;
    counts[1] = ranks;
    if (ranks > sweep->in_a_row || ranks > sweep->cells[1]) scaling_divide(sweep->cells, ranks, counts);
}

double scaling_sweep_blocks(const scaling_sweep* sweep) {
    const double planes = min_int(sweep->planes, sweep->cells[2]);
    return sweep->directions / octant_group(sweep) * (sweep->cells[2] / planes);
}

double scaling_sweep_idle(const scaling_sweep* sweep, const int32_t counts[2]) {
    const int32_t x = counts[0], y = counts[1];
    if (sweep->schedule == SCALING_KBA) return 4.0 * (x - 1 + y - 1); /* Sec. 3 (Baker & Koch 1998) */
    return x + x % 2 + y + y % 2 - 4;                                 /* N_idle for P_z = 1 (Adams et al. 2020) */
}

/* Seconds of a block's cells, and of the messages to its two neighbours downstream. */
static void time_block(const scaling_sweep* sweep, const scaling_network* network, const int32_t counts[2],
                       double* compute, double* messages) {
    const double planes = min_int(sweep->planes, sweep->cells[2]), group = octant_group(sweep);
    const double nx = part(sweep->cells[0], counts[0]), ny = part(sweep->cells[1], counts[1]);
    const double faces = planes * group * sweep->face_bytes;
    *compute = sweep->cell_seconds * nx * ny * planes * group * (counts[0] > 1 ? sweep->octant_factor : 1);
    *messages = 0;
    if (counts[0] > 1) *messages += scaling_message(network, ny * faces);
    if (counts[1] > 1) *messages += scaling_message(network, nx * faces);
}

double scaling_sweep_seconds(const scaling_sweep* sweep, const scaling_network* network, int32_t ranks) {
    int32_t counts[2];
    double compute, messages;
    scaling_sweep_divide(sweep, ranks, counts);
    time_block(sweep, network, counts, &compute, &messages);
    return (scaling_sweep_blocks(sweep) + scaling_sweep_idle(sweep, counts)) * (compute + messages);
}

int32_t scaling_best_planes(const scaling_sweep* sweep, const scaling_network* network, int32_t ranks) {
    scaling_sweep tried = *sweep;
    int32_t best = 1;
    double min_seconds = INFINITY;
    for (tried.planes = 1; tried.planes <= sweep->cells[2]; tried.planes *= 2) {
        const double seconds = scaling_sweep_seconds(&tried, network, ranks);
        if (seconds >= min_seconds) continue;
        min_seconds = seconds;
        best = tried.planes;
    }
    return best;
}

double scaling_sweep_efficiency(const scaling_sweep* sweep, const scaling_network* network, int32_t ranks) {
    int32_t counts[2];
    double compute, messages;
    scaling_sweep_divide(sweep, ranks, counts);
    time_block(sweep, network, counts, &compute, &messages);
    return 1 / ((1 + scaling_sweep_idle(sweep, counts) / scaling_sweep_blocks(sweep)) * (1 + messages / compute));
}

/* ---- multigrid ---- */

static double count_cells(const int32_t cells[3]) {
    return (double)cells[0] * cells[1] * cells[2];
}

/* Cells of half the resolution, at least one along each axis; false at the coarsest level. */
static int coarsen(int32_t cells[3]) {
    if (count_cells(cells) <= 1) return 0;
    for (int a = 0; a < 3; ++a) cells[a] = (cells[a] + 1) / 2;
    return 1;
}

double scaling_multigrid_cells(const scaling_multigrid* grid) {
    int32_t cells[3] = {grid->cells[0], grid->cells[1], grid->cells[2]};
    double sum = 0;
    do sum += count_cells(cells);
    while (coarsen(cells));
    return sum;
}

/* Seconds of a level that all ranks share. */
static double time_level(const scaling_multigrid* grid, const scaling_network* network, const int32_t cells[3],
                         const int32_t counts[2]) {
    const double nx = part(cells[0], counts[0]), ny = part(cells[1], counts[1]), nz = cells[2];
    const int sides[2] = {min_int(counts[0] - 1, 2), min_int(counts[1] - 1, 2)};
    const double halo = sides[0] * scaling_message(network, ny * nz * grid->face_bytes) +
                        sides[1] * scaling_message(network, nx * nz * grid->face_bytes);
    return grid->cell_seconds * nx * ny * nz + grid->exchanges * halo;
}

double scaling_multigrid_seconds(const scaling_multigrid* grid, const scaling_network* network, int32_t ranks) {
    int32_t cells[3] = {grid->cells[0], grid->cells[1], grid->cells[2]}, counts[2];
    double cycle = 0;
    int gathered = ranks < 2;
    do {
        if (!gathered && count_cells(cells) <= grid->gathered_cells) {
            gathered = 1; /* a message from and to every rank */
            cycle += 2 * (ranks - 1) * network->latency + count_cells(cells) * grid->cell_bytes / network->bandwidth;
        }
        scaling_divide(cells, gathered ? 1 : ranks, counts);
        cycle += time_level(grid, network, cells, counts);
    } while (coarsen(cells));
    return grid->cycles * cycle;
}

/* ---- memory ---- */

double scaling_memory(const int32_t cells[3], double cell_bytes, double face_bytes, int32_t ranks) {
    int32_t counts[2];
    scaling_divide(cells, ranks, counts);
    const double nx = part(cells[0], counts[0]), ny = part(cells[1], counts[1]), nz = cells[2];
    return nz * (nx * ny * cell_bytes + 2 * (nx + ny) * face_bytes);
}
