/* Arena allocation from a single block. Without a base it only counts, so that the layout code also computes the size.
 */
#ifndef TY_BASE_ARENA_H
#define TY_BASE_ARENA_H

#include <stddef.h>

typedef struct ty_arena {
    char* base; /* aligned to 64 bytes */
    size_t used;
} ty_arena;

/* Allocates bytes aligned to 64; NULL without a base. */
static inline void* ty_arena_take(ty_arena* arena, size_t bytes) {
    void* address = arena->base != NULL ? arena->base + arena->used : NULL;
    arena->used += (bytes + 63) / 64 * 64;
    return address;
}

#endif
