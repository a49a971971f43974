/* The effort of tests: `make test` takes fewer samples, and fewer of cases that are alike; `make validate` has the same
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

/* Leaves a case to `make validate` that is much like another of the program. */
static inline void leave_to_full_runs(void) {
    if (!in_full()) skip();
}

/* 1 / part of them, which makes noise sqrt(part) times as large. */
static inline int32_t fewer(int32_t samples, int32_t part) {
    return in_full() ? samples : samples / part;
}

/* The compilers say so in different ways. */
#if defined __has_feature
#if __has_feature(address_sanitizer)
#define UNDER_ADDRESS_SANITIZER true
#elif __has_feature(thread_sanitizer)
#define UNDER_THREAD_SANITIZER true
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
#define UNDER_ADDRESS_SANITIZER true
#endif
#ifdef __SANITIZE_THREAD__
#define UNDER_THREAD_SANITIZER true
#endif
#ifndef UNDER_ADDRESS_SANITIZER
#define UNDER_ADDRESS_SANITIZER false
#endif
#ifndef UNDER_THREAD_SANITIZER
#define UNDER_THREAD_SANITIZER false
#endif

/* Leaves a test of what several threads do to the builds with all optimisation and with the thread sanitizer. */
static inline void skip_under_address_sanitizer(void) {
    if (UNDER_ADDRESS_SANITIZER) skip();
}

/* Leaves a test of how near numbers are, or of how many steps they take, to the optimised build: sanitizers make it
 * slow and look for other things, which other tests of the same code lead them to. */
static inline void skip_under_sanitizers(void) {
    if (UNDER_ADDRESS_SANITIZER || UNDER_THREAD_SANITIZER) skip();
}

/* For tests whose code nothing else leads sanitizers to: there the code runs with fewer samples, and numbers, which the
 * optimised build checks with all of them, are not compared. */
static inline bool numbers_count(void) {
    return !(UNDER_ADDRESS_SANITIZER || UNDER_THREAD_SANITIZER);
}

static inline int32_t fewer_under_sanitizers(int32_t samples, int32_t part) {
    return numbers_count() ? samples : samples / part;
}

#endif
