/* How much tests do: `make test` takes fewer samples, and fewer of cases that are alike; `make validate` has the same
 * programs take all (tests/CMakeLists.txt). */
#ifndef TY_TESTS_EFFORT_H
#define TY_TESTS_EFFORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

static inline bool in_full(void) {
    return getenv("TYNDALL_IN_FULL") != NULL;
}

/* 1 / part of them, which makes noise sqrt(part) times as large. */
static inline int32_t fewer(int32_t samples, int32_t part) {
    return in_full() ? samples : samples / part;
}

/* Leaves a test of how near numbers are, or of how many steps they take, to the optimised build: the address sanitizer
 * makes it slow and looks for other things, which other tests of the same code lead it to. */
static inline void skip_under_sanitizers(void) {
#ifdef __SANITIZE_ADDRESS__
    skip();
#endif
}

#endif
