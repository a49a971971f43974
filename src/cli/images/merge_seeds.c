/* The random seeds of an image. */
#include "cli/images/merge_seeds.h"
#include "cli/options/options.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool contains(const cli_seeds* seeds, uint64_t seed) {
    for (size_t i = 0; i < seeds->count; ++i)
        if (seeds->values[i] == seed) return true;
    return false;
}

static bool add(cli_seeds* seeds, uint64_t seed) {
    if (contains(seeds, seed)) return true;
    if (seeds->count == seeds->capacity) {
        const size_t grown = 2 * seeds->capacity + 4;
        uint64_t* moved = realloc(seeds->values, grown * sizeof *moved);
        if (moved == NULL) return false;
        seeds->values = moved;
        seeds->capacity = grown;
    }
    seeds->values[seeds->count++] = seed;
    return true;
}

bool cli_seeds_add(cli_seeds* seeds, const char* text) {
    for (const char* at = text; at != NULL;) {
        char word[24];
        uint64_t seed = 0;
        const size_t length = strcspn(at, ",");
        if (length >= sizeof word) return false;
        memcpy(word, at, length);
        word[length] = '\0';
        if (!cli_parse_seed(word, &seed) || !add(seeds, seed)) return false;
        at = at[length] == ',' ? at + length + 1 + strspn(at + length + 1, " ") : NULL;
    }
    return true;
}

bool cli_seeds_shared(const cli_seeds* a, const cli_seeds* b, uint64_t* seed) {
    for (size_t i = 0; i < a->count; ++i)
        if (contains(b, a->values[i])) {
            *seed = a->values[i];
            return true;
        }
    return false;
}

char* cli_seeds_text(const cli_seeds* seeds) {
    const size_t longest = 22, size = seeds->count * longest + 1; /* "18446744073709551615, " */
    char* text = malloc(size);
    if (text == NULL) return NULL;
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < seeds->count; ++i)
        used += (size_t)snprintf(text + used, size - used, "%s%" PRIu64, i == 0 ? "" : ", ", seeds->values[i]);
    return text;
}

void cli_seeds_free(cli_seeds* seeds) {
    free(seeds->values);
    *seeds = (cli_seeds){0};
}
