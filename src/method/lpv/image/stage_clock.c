/* Processor time of the stages within a pass over tiles. */
#define _POSIX_C_SOURCE 200809L
#include "method/lpv/image/stage_clock.h"

#include <time.h>

int64_t ty_lpv_clock_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

int64_t ty_lpv_clock_add(ty_lpv_stage_clocks* clocks, int stage, int64_t begun) {
    const int64_t now = ty_lpv_clock_now();
    atomic_fetch_add_explicit(&clocks->nanoseconds[stage], now - begun, memory_order_relaxed);
    return now;
}
