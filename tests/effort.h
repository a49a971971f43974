/* How much tests do: `make test` takes fewer samples, and fewer of cases that are alike; `make validate` has the same
 * programs take all (tests/CMakeLists.txt). */
#ifndef TY_TESTS_EFFORT_H
#define TY_TESTS_EFFORT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

static inline bool in_full(void) {
    return getenv("TYNDALL_IN_FULL") != NULL;
}

/* 1 / part of them, which makes noise sqrt(part) times as large. */
static inline int32_t fewer(int32_t samples, int32_t part) {
    return in_full() ? samples : samples / part;
}

#endif
