/* An allocator that keeps accounts, and fails when told to. */
#ifndef TY_TESTS_LEDGER_H
#define TY_TESTS_LEDGER_H

#include "checks.h"

#include <stdatomic.h>

/* Counts bytes and refuses the n-th allocation. The size is kept in front of each block to check what is freed. */
typedef struct ledger {
    _Atomic int64_t bytes, allocations;
    int64_t refused; /* index of the allocation that fails; -1: none */
    _Atomic bool wrong_size;
} ledger;

enum { HEADER = 64 };

static inline void* ledger_alloc(void* user, size_t size) {
    ledger* book = user;
    if (atomic_fetch_add(&book->allocations, 1) == book->refused) return NULL;
    char* block = aligned_alloc(HEADER, (HEADER + size + HEADER - 1) / HEADER * HEADER);
    if (block == NULL || size == 0) abort();
    memcpy(block, &size, sizeof size);
    atomic_fetch_add(&book->bytes, (int64_t)size);
    return block + HEADER;
}

static inline void ledger_free(void* user, void* pointer, size_t size) {
    ledger* book = user;
    size_t taken = 0;
    char* block = (char*)pointer - HEADER;
    memcpy(&taken, block, sizeof taken);
    if (taken != size) atomic_store(&book->wrong_size, true);
    atomic_fetch_sub(&book->bytes, (int64_t)size);
    free(block);
}

static inline ty_context* ledger_context(ledger* book) {
    ty_context_def def = ty_default_context_def();
    def.threads = 2;
    def.alloc = ledger_alloc;
    def.free = ledger_free;
    def.alloc_user = book;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

/* Fails each allocation of some work in turn: it must say so, and give back everything. */
static inline void check_failed_allocations(ty_result (*work)(ty_context* context)) {
    ledger book = {.refused = -1};
    ty_context* context = ledger_context(&book);
    const int64_t before = atomic_load(&book.bytes);
    ty_result result = TY_ERROR_MEMORY;
    for (int64_t n = 0; result == TY_ERROR_MEMORY; ++n) {
        book.refused = n;
        atomic_store(&book.allocations, 0);
        result = work(context);
        if (atomic_load(&book.bytes) != before) fail_msg("allocation %d leaks when it fails", (int)n);
        if (atomic_load(&book.allocations) > n) {
            if (result != TY_ERROR_MEMORY) fail_msg("allocation %d: %s", (int)n, ty_result_name(result));
            assert_error(context, "not enough memory");
        }
    }
    assert_int_equal(result, TY_OK);
    assert_false(atomic_load(&book.wrong_size));
    ty_context_destroy(context);
    assert_int_equal(atomic_load(&book.bytes), 0);
}

#endif
