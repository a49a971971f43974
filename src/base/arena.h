/* Memory handed out piece by piece from one block. Without a base it only counts, so that the code that lays memory out
 * also says how much that takes. */
#ifndef TY_BASE_ARENA_H
#define TY_BASE_ARENA_H

#include <stddef.h>

typedef struct ty_arena {
    char* base; /* aligned to 64 bytes */
    size_t used;
} ty_arena;

/* A piece aligned to 64 bytes; NULL without a base. */
static inline void* ty_arena_take(ty_arena* arena, size_t bytes) {
    void* place = arena->base != NULL ? arena->base + arena->used : NULL;
    arena->used += (bytes + 63) / 64 * 64;
    return place;
}

#endif
