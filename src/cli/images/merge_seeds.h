/* The random seeds of an image: a number, or several separated by ", ". */
#ifndef TY_CLI_IMAGES_MERGE_SEEDS_H
#define TY_CLI_IMAGES_MERGE_SEEDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct cli_seeds {
    uint64_t* values; /* malloc */
    size_t count, capacity;
} cli_seeds;

/* Adds the seeds of a text to a list without duplicates; false when the text is no list of seeds or memory is short. */
bool cli_seeds_add(cli_seeds* seeds, const char* text);
/* Finds a seed common to two lists. */
bool cli_seeds_shared(const cli_seeds* a, const cli_seeds* b, uint64_t* seed);
/* The list as text; the caller frees it. NULL when memory is short. */
char* cli_seeds_text(const cli_seeds* seeds);
void cli_seeds_free(cli_seeds* seeds);

#endif
