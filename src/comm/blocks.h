/* Blocks of a loop that rank 0 takes from the front, one by one, and other ranks from the back, several at once. Who
 * computes a block changes no bit of it. */
#ifndef TY_COMM_BLOCKS_H
#define TY_COMM_BLOCKS_H

#include <tyndall/base.h>

#include <stdatomic.h>
#include <stdint.h>

typedef struct ty_blocks {
    _Atomic uint8_t* states; /* count of them */
    int64_t count;
    _Atomic int64_t end;     /* blocks behind it are taken */
    _Atomic int64_t untaken; /* blocks that nobody has taken */
    _Atomic int64_t away;    /* blocks that other ranks have */
} ty_blocks;

/* False: no memory. Then, and for zeroed blocks, ty_blocks_destroy may be called. */
bool ty_blocks_create(ty_blocks* blocks, int64_t count);
void ty_blocks_destroy(ty_blocks* blocks);
/* Makes all blocks free. */
void ty_blocks_reset(ty_blocks* blocks);

/* Takes a block for this process: false if another rank has it, or it is done. */
bool ty_blocks_take(ty_blocks* blocks, int64_t block);
/* Takes up to `max_count` blocks [*first, *first + n) for one of so many ranks, and at most a fair part of those that
 * are left; the result is n. */
int64_t ty_blocks_lend(ty_blocks* blocks, int64_t max_count, int32_t ranks, int64_t* first);
/* Another rank has computed a block: false if that is of no use, since this process has taken it back meanwhile. After
 * true the block counts as away until the caller has its result and settles that. */
bool ty_blocks_return(ty_blocks* blocks, int64_t block);
void ty_blocks_settle(ty_blocks* blocks);
/* Takes back a block from a rank that does not answer: false if no rank has it. */
bool ty_blocks_take_back(ty_blocks* blocks, int64_t block);

#endif
