/* --aov: the channels beside R, G and B. */
#ifndef TY_CLI_AOVS_H
#define TY_CLI_AOVS_H

#include <tyndall/tyndall.h>

typedef struct cli_aov_word {
    const char* name;
    uint32_t aovs;
} cli_aov_word;

/* "one,another" as the flags of those words together: CLI_GO, or CLI_USAGE after a message. */
int cli_parse_aov_words(const char* command, const char* text, const cli_aov_word* words, int count, uint32_t* aovs);

/* "depth,normal" or "all" as TY_AOV_...: CLI_GO, or CLI_USAGE after a message. */
int cli_parse_aovs(const char* command, const char* text, uint32_t* aovs);

/* The name of one of these channels that is not among the known ones, or NULL. */
const char* cli_aov_outside(uint32_t aovs, uint32_t known);

/* Takes samples.N out of an image when it says the same everywhere. */
ty_result cli_drop_even_samples(ty_context* context, ty_image** image);

#endif
