/* Sweeps of discrete ordinates on devices: a solve of a cloud, its bits and times. */
#include "bench/device.h"
#include "bench/ordinates_box.h"

#include "solve/ordinates/sweep.h"

#include <string.h>

enum { SIDE = 64, TEST_SIDE = 16, DIRECTIONS = 80 };

/* Of a cell and direction: the source's moments and harmonics, extinction, radiance at three faces, read and written,
 * and the mean; and the means and harmonics of the resulting moments. Most come from caches. */
static double step_bytes(int32_t terms) {
    return sizeof(float) * (2.0 * terms + 1 + 6 + 1 + 2.0 * terms);
}

static ty_result open_box(ty_context* context, int32_t side, ordinates_box* box) {
    return ordinates_box_open(context, ORDINATES_BOX_CLOUD, side, DIRECTIONS, 20, box);
}

static ty_result solve_test(ty_context* context, ordinates_box* box) {
    ty_ordinates_stats stats;
    const ty_result result = open_box(context, TEST_SIDE, box);
    return result == TY_OK ? ordinates_box_solve(context, box, NULL, 0, &stats) : result;
}

/* Cells whose fluence differs in any bit from the host twin's. */
static ty_result test(const bench_contexts* all, int64_t* unlike) {
    ordinates_box boxes[2] = {{.cells = 0}, {.cells = 0}};
    ty_context* const contexts[2] = {all->device, all->host};
    ty_result result = TY_OK;
    for (int i = 0; i < 2 && result == TY_OK; ++i) result = solve_test(contexts[i], &boxes[i]);
    for (size_t i = 0; result == TY_OK && i < boxes[0].cells; ++i)
        *unlike += memcmp(&boxes[0].fluence[i], &boxes[1].fluence[i], sizeof(float)) != 0;
    for (int i = 0; i < 2; ++i) ordinates_box_close(&boxes[i]);
    return result;
}

/* Median seconds of the sweeps of a solve, with what processor and device exchange, and of a device's launches. */
static ty_result time_solve(const bench_session* bench, ty_context* context, ty_device* gpu, ordinates_box* box,
                            ty_ordinates_stats* stats, double* seconds, double* launched) {
    double all[BENCH_DEVICE_RUNS_MAX], on_device[BENCH_DEVICE_RUNS_MAX] = {0};
    for (int run = -1; run < bench->options->runs; ++run) {
        if (gpu != NULL) gpu->backend->time(gpu);
        const ty_result result = ordinates_box_solve(context, box, NULL, 0, stats);
        if (result != TY_OK) return result;
        if (run >= 0) all[run] = stats->sweep_seconds;
        if (run >= 0 && gpu != NULL) on_device[run] = gpu->backend->time(gpu);
    }
    *seconds = bench_median(all, bench->options->runs);
    *launched = bench_median(on_device, bench->options->runs);
    return TY_OK;
}

ty_result bench_measure_ordinates(const bench_session* bench, const bench_contexts* all, bench_measurement* m) {
    const int32_t side = bench->options->quick ? TEST_SIDE : SIDE;
    ordinates_box on_device = {.cells = 0}, on_cpu = {.cells = 0};
    ty_ordinates_stats stats;
    double none;
    ty_result result = test(all, &m->unlike);
    if (result == TY_OK) result = open_box(all->device, side, &on_device);
    if (result == TY_OK)
        result = time_solve(bench, all->device, all->gpu, &on_device, &stats, &m->seconds, &m->launched);
    if (result == TY_OK) {
        const int32_t bands = on_device.def.bands;
        const double steps = (double)stats.sweeps * (double)on_device.cells * on_device.set.count;
        m->operations = ty_sweep_operations(bands) * steps;
        m->bytes = step_bytes(bands * bands) * steps;
        result = open_box(all->cpu, side, &on_cpu);
    }
    if (result == TY_OK) result = time_solve(bench, all->cpu, NULL, &on_cpu, &stats, &m->cpu, &none);
    ordinates_box_close(&on_device);
    ordinates_box_close(&on_cpu);
    return result;
}
