/* --aov: the channels beside R, G and B. */
#ifndef TY_CLI_OPTIONS_AOVS_H
#define TY_CLI_OPTIONS_AOVS_H

#include <tyndall/tyndall.h>

typedef struct cli_aov_word {
    const char* name;
    uint32_t aovs;
} cli_aov_word;

/* Parses "one,another" into the OR of the words' flags: CLI_GO, or CLI_USAGE after a message. */
int cli_parse_aov_words(const char* command, const char* text, const cli_aov_word* words, int count, uint32_t* aovs);

/* Parses "depth,normal" or "all" into TY_AOV_... flags: CLI_GO, or CLI_USAGE after a message. */
int cli_parse_aovs(const char* command, const char* text, uint32_t* aovs);

/* The name of the first unknown channel, or NULL. */
const char* cli_aov_outside(uint32_t aovs, uint32_t known);

/* Removes the channel samples.N from an image where it is constant. */
ty_result cli_drop_even_samples(ty_context* context, ty_image** image);

#endif
