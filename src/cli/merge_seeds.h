/* The seeds an image was made of: a number, or several with ", " between them. */
#ifndef TY_CLI_MERGE_SEEDS_H
#define TY_CLI_MERGE_SEEDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct cli_seeds {
    uint64_t* values; /* malloc */
    size_t count, capacity;
} cli_seeds;

/* Adds the seeds in text that are not there yet; false when text is no such list or memory is short. */
bool cli_seeds_add(cli_seeds* seeds, const char* text);
/* Finds a seed that two lists share. */
bool cli_seeds_shared(const cli_seeds* a, const cli_seeds* b, uint64_t* seed);
/* As text, to be freed; NULL when memory is short. */
char* cli_seeds_text(const cli_seeds* seeds);
void cli_seeds_free(cli_seeds* seeds);

#endif
