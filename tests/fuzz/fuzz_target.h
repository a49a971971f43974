/* Shared by the fuzz targets: a context that cannot take much memory, which also tests running out of it. */
#ifndef TY_TESTS_FUZZ_TARGET_H
#define TY_TESTS_FUZZ_TARGET_H

#include <tyndall/base.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

#ifndef FUZZ_MEMORY
#define FUZZ_MEMORY (1 << 26) /* bytes; a target may have its own limit */
#endif

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

/* Reads a file in memory by its path, and closes it. */
static inline int fuzz_read_file(int file, void (*read_all)(ty_context* context, const char* path)) {
    char path[64];
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    read_all(context, path);
    fuzz_finish(context, &used);
    close(file);
    return 0;
}

/* The same of bytes. */
static inline int fuzz_read_bytes(const uint8_t* bytes, size_t size,
                                  void (*read_all)(ty_context* context, const char* path)) {
    const int file = memfd_create("fuzz", MFD_CLOEXEC);
    if (file < 0 || write(file, bytes, size) != (ssize_t)size) abort();
    return fuzz_read_file(file, read_all);
}

/* A copy that ends in a zero, as files that are read do; to be freed. */
static inline uint8_t* fuzz_copy_text(const uint8_t* bytes, size_t size) {
    uint8_t* text = malloc(size + 1);
    if (text == NULL) abort();
    if (size > 0) memcpy(text, bytes, size);
    text[size] = 0;
    return text;
}

#endif
