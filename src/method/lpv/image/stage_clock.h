/* Processor time of the stages within a pass over tiles. */
#ifndef TY_METHOD_LPV_STAGE_CLOCK_H
#define TY_METHOD_LPV_STAGE_CLOCK_H

#include <stdatomic.h>
#include <stdint.h>

/* TY_CLOCK_RAYS is the part of the other stages spent in ray tracing. */
enum { TY_CLOCK_VIEW, TY_CLOCK_SURFACES, TY_CLOCK_MARCH, TY_CLOCK_SINGLE, TY_CLOCK_RAYS, TY_CLOCKS };

/* Sums over all threads, ns. */
typedef struct ty_lpv_stage_clocks {
    _Atomic int64_t nanoseconds[TY_CLOCKS];
} ty_lpv_stage_clocks;

/* Monotonic time, ns. */
int64_t ty_lpv_clock_now(void);
/* Adds the time since `begun` to one stage; returns the time now. */
int64_t ty_lpv_clock_add(ty_lpv_stage_clocks* clocks, int stage, int64_t begun);

#endif
