/* Arrays in files: the operating system pages them in from the file where they are read, and out again where memory is
 * short, so that they may be larger than memory. */
#ifndef TY_BASE_MAPPING_H
#define TY_BASE_MAPPING_H

#include <tyndall/base.h>

#include <pthread.h>
#include <stdatomic.h>

/* A mapped file. The mappings of a context are a ring. */
typedef struct ty_mapping {
    ty_context* context;
    char* path; /* NULL: a file without a name, of the process's own */
    int descriptor;
    uint8_t* bytes;
    size_t size;
    size_t kept;        /* the first bytes, which ty_mappings_trim leaves in memory */
    int64_t changed[2]; /* time of the file's last change: seconds, nanoseconds */
    struct ty_mapping *next, *previous;
} ty_mapping;

/* The mappings of a context, and the place where their pages were unloaded last. */
typedef struct ty_mapping_ring {
    pthread_mutex_t lock; /* guards hand and offset */
    _Atomic int32_t count;
    ty_mapping* hand;
    size_t offset;
    size_t limit;              /* bytes of all mappings in the process's memory; 0: as the operating system decides */
    size_t others;             /* bytes of other files there, the program's own and libraries */
    _Atomic int64_t next_look; /* ns of a monotonic clock */
} ty_mapping_ring;

void ty_mapping_ring_create(ty_mapping_ring* ring, size_t limit);
void ty_mapping_ring_destroy(ty_mapping_ring* ring);

/* A file of `size` bytes, all 0, in the folder that TMPDIR names, else /tmp, which ends with its mapping. Its space on
 * the disk is reserved, so that writing to the array does not fail. Errors: TY_ERROR_FILE, TY_ERROR_MEMORY. */
ty_result ty_mapping_create(ty_context* context, size_t size, ty_mapping** out);
/* Maps a regular file for reading. A file that becomes shorter meanwhile raises SIGBUS where it is read.
 * Errors: TY_ERROR_FILE, TY_ERROR_INPUT (an empty file), TY_ERROR_MEMORY. */
ty_result ty_mapping_open(ty_context* context, const char* path, ty_mapping** out);
/* From here on its pages, but for the kept ones, are read in no order: none is read with those behind it, which would
 * push out others. */
void ty_mapping_expect_random(ty_mapping* mapping);
/* Has pages read that are needed soon. */
void ty_mapping_prefetch(const ty_mapping* mapping, const void* from, size_t bytes);
/* Unloads the pages between two offsets, which are read again where they are needed. */
void ty_mapping_unload(const ty_mapping* mapping, size_t from, size_t to);
/* NULL is allowed. */
void ty_mapping_close(ty_mapping* mapping);

/* As ty_alloc_array, for arrays of many cells: in a file without a name, of which ty_mappings_trim has no more in
 * memory than its limit, where there is a limit and the array is large. */
void* ty_alloc_large(ty_context* context, size_t count, size_t size, bool zero);
/* Frees an array of ty_alloc_large or ty_alloc_array; NULL is allowed. */
void ty_free_large(ty_context* context, void* array, size_t count, size_t size);

/* True if ty_mappings_trim has mappings and a limit to look at. */
bool ty_mappings_are_bounded(ty_context* context);
/* Unloads pages in turn, from the place where the last call ended, where those in memory exceed the limit. It looks
 * every two milliseconds, in one thread. */
void ty_mappings_trim(ty_context* context);
/* Fails with TY_ERROR_INPUT if a mapped file was changed since it was opened. */
ty_result ty_mappings_check(ty_context* context);

#endif
