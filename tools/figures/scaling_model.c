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

scaling_stages scaling_kba(const scaling_sweep* sweep, int32_t ranks, int32_t planes) {
    scaling_stages s;
    const double depth = min_int(planes, sweep->cells[2]);
    scaling_divide(sweep->cells, ranks, s.ranks);
    s.units = 8 * sweep->cells[2] / depth;
    s.stages = s.units + 4.0 * (s.ranks[0] - 1 + s.ranks[1] - 1); /* Sec. 3 (Baker & Koch 1998) */
    s.messages = s.bytes = 0;
    for (int a = 0; a < 2; ++a) {
        if (s.ranks[a] == 1) continue;
        s.messages += s.units;
        s.bytes +=
            sizeof(float) * (double)part(sweep->cells[1 - a], s.ranks[1 - a]) * sweep->cells[2] * sweep->directions;
    }
    return s;
}

double scaling_sweep_seconds(const scaling_sweep* sweep, const scaling_network* network, const scaling_stages* stages) {
    const double cells =
        (double)part(sweep->cells[0], stages->ranks[0]) * part(sweep->cells[1], stages->ranks[1]) * sweep->cells[2];
    const double factor = stages->ranks[0] > 1 ? sweep->octant_factor : 1;
    const double work = sweep->cell_seconds * factor * cells * sweep->directions;
    const double messages = stages->messages * network->latency + stages->bytes / network->bandwidth;
    return stages->stages / stages->units * (work + messages);
}

scaling_stages scaling_best_kba(const scaling_sweep* sweep, const scaling_network* network, int32_t ranks) {
    scaling_stages best = scaling_kba(sweep, ranks, 1);
    for (int32_t planes = 2; planes <= sweep->cells[2]; planes *= 2) {
        const scaling_stages tried = scaling_kba(sweep, ranks, planes);
        if (scaling_sweep_seconds(sweep, network, &tried) < scaling_sweep_seconds(sweep, network, &best)) best = tried;
    }
    return best;
}

/* ---- multigrid ---- */

double scaling_cycle_seconds(const scaling_cycle* cycle, const scaling_network* network, double cell_seconds) {
    return cell_seconds * cycle->cells + cycle->messages * network->latency + cycle->bytes / network->bandwidth;
}
