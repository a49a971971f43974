/* Number of rays traced, and the time spent on them. */
#ifndef TY_SCENE_SURFACES_RAY_COUNTER_H
#define TY_SCENE_SURFACES_RAY_COUNTER_H

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ty_ray_counter {
    _Atomic int64_t rays, nanoseconds; /* summed over all threads */
} ty_ray_counter;

/* Thread safe; counter may be NULL. */
static inline void ty_ray_counter_add(ty_ray_counter* counter, int64_t rays, double seconds) {
    if (counter == NULL) return;
    atomic_fetch_add_explicit(&counter->rays, rays, memory_order_relaxed);
    atomic_fetch_add_explicit(&counter->nanoseconds, (int64_t)(1e9 * seconds), memory_order_relaxed);
}

#endif
