#include "solve/ordinates/sweep_schedule.h"

#include "base/context.h"

#include <string.h>

/* Units per stage of filling the pipeline: ranks wait at most so many times less than they work. */
enum { UNITS_PER_FILL = 8, BLOCKS_MIN = 2 };

ty_sweep_schedule ty_sweep_choose_blocks(const int32_t parts[2], int32_t planes) {
    ty_sweep_schedule s = {.streams = parts[0] > 1 ? 8 : 4};
    const int32_t fill = parts[0] + parts[1] - 2;
    int32_t blocks = (UNITS_PER_FILL * fill + s.streams - 1) / s.streams;
    if (blocks < BLOCKS_MIN) blocks = BLOCKS_MIN;
    if (blocks > planes) blocks = planes;
    s.planes = (planes + blocks - 1) / blocks;
    s.blocks = (planes + s.planes - 1) / s.planes;
    s.count = s.streams * s.blocks;
    return s;
}

/* ---- simulation ---- */

/* All ranks: per rank and stream, the number of blocks that are done, and how many were before this stage. */
typedef struct simulation {
    const int32_t* parts;
    int32_t streams, blocks;
    int16_t *done, *before;
} simulation;

static int16_t* blocks_of(const simulation* sim, int16_t* blocks, int32_t i, int32_t j) {
    return blocks + (ptrdiff_t)sim->streams * (i + (ptrdiff_t)sim->parts[0] * j);
}

/* Direction of a stream along an axis: 1, -1, or 0 where both are in it. */
static int32_t step_of(const simulation* sim, int32_t stream, int axis) {
    if (sim->streams == 4) return axis == 0 ? 0 : 1 - 2 * (stream & 1);
    return 1 - 2 * (stream >> axis & 1);
}

static bool is_ready(const simulation* sim, const int32_t at[2], int32_t stream) {
    const int16_t next = blocks_of(sim, sim->before, at[0], at[1])[stream];
    if (next == sim->blocks) return false;
    for (int axis = 0; axis < 2; ++axis) {
        int32_t upwind[2] = {at[0], at[1]};
        const int32_t step = step_of(sim, stream, axis);
        upwind[axis] -= step;
        if (step == 0 || upwind[axis] < 0 || upwind[axis] >= sim->parts[axis]) continue;
        if (blocks_of(sim, sim->before, upwind[0], upwind[1])[stream] <= next) return false;
    }
    return true;
}

static int32_t ranks_downwind(const simulation* sim, const int32_t at[2], int32_t stream) {
    int32_t sum = 0;
    for (int axis = 0; axis < 2; ++axis) {
        const int32_t step = step_of(sim, stream, axis);
        if (step > 0) sum += sim->parts[axis] - 1 - at[axis];
        if (step < 0) sum += at[axis];
    }
    return sum;
}

/* The stream that a rank goes on with; negative: none is ready. */
static int32_t choose_stream(const simulation* sim, const int32_t at[2]) {
    int32_t best = -1, max_downwind = -1;
    for (int32_t s = 0; s < sim->streams; ++s) {
        const int32_t downwind = ranks_downwind(sim, at, s);
        if (downwind <= max_downwind || !is_ready(sim, at, s)) continue;
        best = s;
        max_downwind = downwind;
    }
    return best;
}

static void add_unit(const simulation* sim, int32_t stream, int16_t step, int32_t index, ty_sweep_unit* units) {
    const bool down = (sim->streams == 4 ? stream >> 1 : stream >> 2 & 1) != 0;
    ty_sweep_unit unit = {.stream = (int16_t)stream, .block = (int16_t)(down ? sim->blocks - 1 - step : step)};
    int32_t before = 0;
    for (int32_t u = 0; u < index; ++u) before += units[u].block == unit.block;
    unit.first = before == 0;
    unit.last = before + 1 == sim->streams;
    units[index] = unit;
}

/* One unit of every rank that has one ready. Returns whether any had. */
static bool run_stage(simulation* sim, const int32_t own[2], int32_t* index, ty_sweep_unit* units) {
    bool any = false;
    int32_t at[2];
    for (at[1] = 0; at[1] < sim->parts[1]; ++at[1])
        for (at[0] = 0; at[0] < sim->parts[0]; ++at[0]) {
            const int32_t stream = choose_stream(sim, at);
            if (stream < 0) continue;
            int16_t* done = &blocks_of(sim, sim->done, at[0], at[1])[stream];
            if (units != NULL && at[0] == own[0] && at[1] == own[1]) add_unit(sim, stream, *done, (*index)++, units);
            ++*done;
            any = true;
        }
    return any;
}

ty_result ty_sweep_schedule_make(ty_context* context, const int32_t parts[2], const int32_t at[2],
                                 ty_sweep_schedule* schedule) {
    const size_t items = (size_t)schedule->streams * (size_t)parts[0] * (size_t)parts[1];
    simulation sim = {.parts = parts, .streams = schedule->streams, .blocks = schedule->blocks};
    sim.done = ty_alloc_array(context, 2 * items, sizeof *sim.done, true);
    schedule->units = ty_alloc_array(context, (size_t)schedule->count, sizeof *schedule->units, true);
    const bool good = sim.done != NULL && schedule->units != NULL;
    schedule->stages = 0;
    for (int32_t index = 0; good; ++schedule->stages) {
        sim.before = sim.done + items;
        memcpy(sim.before, sim.done, items * sizeof *sim.done);
        if (!run_stage(&sim, at, &index, schedule->units)) break;
    }
    if (sim.done != NULL) ty_free_array(context, sim.done, 2 * items, sizeof *sim.done);
    return good ? TY_OK : TY_ERROR_MEMORY;
}

void ty_sweep_schedule_free(ty_context* context, ty_sweep_schedule* schedule) {
    if (schedule->units == NULL) return;
    ty_free_array(context, schedule->units, (size_t)schedule->count, sizeof *schedule->units);
    schedule->units = NULL;
}
