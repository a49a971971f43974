/* Contexts and calls that the parts of bench device share. */
#ifndef TY_BENCH_DEVICE_H
#define TY_BENCH_DEVICE_H

#include "bench/bench.h"

#include "device/device.h"

enum { BENCH_DEVICE_RUNS_MAX = 99 };

/* A context of the processor by its own kernels, of the host twin, and of the device that the session has. */
typedef struct bench_contexts {
    ty_context *cpu, *host, *device;
    ty_device* gpu;
} bench_contexts;

/* Loads builtin:NAME. */
ty_result bench_device_load(ty_context* context, const char* name, ty_scene** out);
/* Values of all channels of two images of one size that differ in any bit. */
int64_t bench_count_unlike(const ty_image* a, const ty_image* b);

/* Times of a program, and what they are of. */
typedef struct bench_measurement {
    double seconds, launched, cpu;
    double bytes, operations;
    int64_t unlike; /* values that differ in any bit from the host twin's */
} bench_measurement;

/* Propagation as in the paper's Table 1: 8 iterations in 32^3 cells. */
ty_result bench_measure_propagation(const bench_session* bench, const bench_contexts* all, bench_measurement* m);

/* A solve by discrete ordinates, whose sweeps run on the device. */
ty_result bench_measure_ordinates(const bench_session* bench, const bench_contexts* all, bench_measurement* m);

/* Marching, screen-space scattering, propagation and sweeps: an object `programs`, whose members have times beside the
 * processor's, fractions of the device's peak bandwidth and arithmetic (0: unknown), and values unlike the host twin's,
 * which are added to *unlike. */
ty_result bench_device_programs(const bench_session* bench, const bench_contexts* all, int64_t* unlike);

#endif
