/* Flushes denormals to zero on the calling thread: arithmetic on denormals is about a hundred times slower, and Embree
 * requires it. */
#ifndef TY_BASE_FLOAT_MODE_H
#define TY_BASE_FLOAT_MODE_H

#if defined(__SSE2__)
#include <immintrin.h>
#endif

/* Returns the previous state, for restoring. */
static inline unsigned ty_flush_denormals(void) {
#if defined(__SSE2__)
    const unsigned state = _mm_getcsr();
    _mm_setcsr(state | 0x8040u); /* flush to zero, denormals are zero */
    return state;
#else
    return 0;
#endif
}

static inline void ty_restore_denormals(unsigned state) {
#if defined(__SSE2__)
    _mm_setcsr(state);
#else
    (void)state;
#endif
}

#endif
