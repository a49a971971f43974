/* What the fuzz targets share: a context that cannot take much memory, which also tests running out of it. */
#ifndef TY_TESTS_FUZZ_TARGET_H
#define TY_TESTS_FUZZ_TARGET_H

#include <tyndall/base.h>

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

enum { FUZZ_MEMORY = 1 << 26 };

static inline void* fuzz_alloc(void* user, size_t size) {
    size_t* used = user;
    if (size > FUZZ_MEMORY - *used) return NULL;
    void* pointer = aligned_alloc(64, (size + 63) / 64 * 64);
    if (pointer != NULL) *used += size;
    return pointer;
}

static inline void fuzz_free(void* user, void* pointer, size_t size) {
    size_t* used = user;
    *used -= size;
    free(pointer);
}

/* used must be 0 and outlive the context. */
static inline ty_context* fuzz_context(size_t* used) {
    ty_context_def def = ty_default_context_def();
    def.threads = 1;
    def.alloc = fuzz_alloc;
    def.free = fuzz_free;
    def.alloc_user = used;
    ty_context* context = NULL;
    if (ty_context_create(&def, &context) != TY_OK) abort();
    return context;
}

/* Everything that was taken must have been given back. */
static inline void fuzz_finish(ty_context* context, const size_t* used) {
    ty_context_destroy(context);
    if (*used != 0) abort();
}

#endif
