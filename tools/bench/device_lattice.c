/* Propagation in a lattice on devices. */
#include "bench/device.h"

#include "method/lpv/propagate/propagate.h"

#include <string.h>

enum { SIDE = 32, BANDS = 2, TERMS = BANDS * BANDS, ITERATIONS = 8 };

/* Floats of a cell in a step: its light before and after, the sum that every other step adds both to, and sums of
 * strips; the light of neighbours comes from caches. Operations beside those of the links: scattering and sums. */
static const double cell_floats = 3 * TERMS + 3 * TERMS + 3 * TERMS + 2 * 3 * 5 / 4.0;
static const double cell_operations = 3 * (TERMS + TERMS + 6);

/* A propagation of a sample. */
static ty_result propagate(ty_context* context, int32_t side, ty_lattice** out, double* seconds) {
    const ty_lpv_def def = {.mode = TY_LPV_MODE_PUBLISHED, .iterations = ITERATIONS};
    ty_lattice_power power = {.iterations = 0};
    ty_result result = ty_lattice_create_sample(context, side, BANDS, false, out);
    if (result == TY_OK) result = ty_lattice_propagate(*out, &def, NULL, NULL, NULL, NULL, &power);
    *seconds = power.propagate_seconds;
    return result;
}

static ty_result time_propagation(const bench_session* bench, ty_context* context, ty_device* gpu, int32_t side,
                                  double* seconds, double* launched) {
    double all[BENCH_DEVICE_RUNS_MAX], on_device[BENCH_DEVICE_RUNS_MAX] = {0};
    for (int run = -1; run < bench->options->runs; ++run) {
        ty_lattice* lattice = NULL;
        double taken;
        if (gpu != NULL) gpu->backend->time(gpu);
        const ty_result result = propagate(context, side, &lattice, &taken);
        ty_lattice_destroy(lattice);
        if (result != TY_OK) return result;
        if (run >= 0) all[run] = taken;
        if (run >= 0 && gpu != NULL) on_device[run] = gpu->backend->time(gpu);
    }
    *seconds = bench_median(all, bench->options->runs);
    *launched = bench_median(on_device, bench->options->runs);
    return TY_OK;
}

static int64_t count_unlike(const ty_lattice* a, const ty_lattice* b) {
    int64_t unlike = 0;
    for (int32_t i = 0; i < 3 * TERMS; ++i) {
        const float *x = a->light[i / TERMS][i % TERMS], *y = b->light[i / TERMS][i % TERMS];
        for (size_t k = 0; k < a->cells; ++k) unlike += memcmp(&x[k], &y[k], sizeof *x) != 0;
    }
    return unlike;
}

ty_result bench_measure_propagation(const bench_session* bench, const bench_contexts* all, bench_measurement* m) {
    const int32_t side = bench->options->quick ? SIDE / 4 : SIDE;
    const double steps = (double)ITERATIONS * side * side * side;
    ty_lattice *on_device = NULL, *on_host = NULL;
    double none;
    ty_result result = propagate(all->device, side, &on_device, &none);
    if (result == TY_OK) result = propagate(all->host, side, &on_host, &none);
    if (result == TY_OK) m->unlike = count_unlike(on_device, on_host);
    if (result == TY_OK) result = time_propagation(bench, all->device, all->gpu, side, &m->seconds, &m->launched);
    if (result == TY_OK) result = time_propagation(bench, all->cpu, NULL, side, &m->cpu, &none);
    m->bytes = sizeof(float) * cell_floats * steps;
    m->operations = (2.0 * ty_lattice_step_operations(BANDS) + cell_operations) * steps;
    ty_lattice_destroy(on_device);
    ty_lattice_destroy(on_host);
    return result;
}
