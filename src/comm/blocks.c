#include "comm/blocks.h"

#include <stdlib.h>

enum { FREE, OWN, AWAY, DONE };

bool ty_blocks_create(ty_blocks* blocks, int64_t count) {
    blocks->states = calloc((size_t)count + 1, sizeof *blocks->states);
    blocks->count = count;
    if (blocks->states != NULL) ty_blocks_reset(blocks);
    return blocks->states != NULL;
}

void ty_blocks_destroy(ty_blocks* blocks) {
    free(blocks->states);
    blocks->states = NULL;
}

void ty_blocks_reset(ty_blocks* blocks) {
    for (int64_t i = 0; i < blocks->count; ++i) atomic_store(&blocks->states[i], FREE);
    atomic_store(&blocks->end, blocks->count);
    atomic_store(&blocks->untaken, blocks->count);
    atomic_store(&blocks->away, 0);
}

static bool change(ty_blocks* blocks, int64_t block, uint8_t from, uint8_t to) {
    return atomic_compare_exchange_strong(&blocks->states[block], &from, to);
}

bool ty_blocks_take(ty_blocks* blocks, int64_t block) {
    if (!change(blocks, block, FREE, OWN)) return false;
    atomic_fetch_sub(&blocks->untaken, 1);
    return true;
}

int64_t ty_blocks_lend(ty_blocks* blocks, int64_t max_count, int32_t ranks, int64_t* first) {
    const int64_t fair = atomic_load(&blocks->untaken) / (2 * ranks);
    const int64_t few = max_count < fair ? max_count : fair, wanted = few > 1 ? few : 1;
    int64_t at = atomic_load(&blocks->end), count = 0;
    while (at > 0 && count < wanted && change(blocks, at - 1, FREE, AWAY)) {
        --at;
        ++count;
    }
    atomic_store(&blocks->end, at);
    atomic_fetch_sub(&blocks->untaken, count);
    atomic_fetch_add(&blocks->away, count);
    *first = at;
    return count;
}

bool ty_blocks_return(ty_blocks* blocks, int64_t block) {
    return change(blocks, block, AWAY, DONE);
}

void ty_blocks_settle(ty_blocks* blocks) {
    atomic_fetch_sub(&blocks->away, 1);
}

bool ty_blocks_take_back(ty_blocks* blocks, int64_t block) {
    if (!change(blocks, block, AWAY, OWN)) return false;
    atomic_fetch_sub(&blocks->away, 1);
    return true;
}
