/* Command lines that reproduce the images of a comparison. */
#define _POSIX_C_SOURCE 200809L
#include "cli/compare/command_line.h"
#include "cli/text/text_file.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* Shell quoting of a word, where needed. */
static void print_word(FILE* file, const char* word) {
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_./:,=+@%";
    if (word[0] != '\0' && word[strspn(word, plain)] == '\0') {
        fputs(word, file);
        return;
    }
    fputc('\'', file);
    for (const char* c = word; *c != '\0'; ++c)
        if (*c == '\'')
            fputs("'\\''", file);
        else
            fputc(*c, file);
    fputc('\'', file);
}

static void print_command(FILE* file, const cli_comparison* comparison, const cli_compared* entry, uint64_t seed) {
    const bool reference = entry == &comparison->reference;
    fputs("tyndall render ", file);
    print_word(file, comparison->subject);
    fprintf(file, " --method %s", entry->source);
    if (entry->spp > 0) fprintf(file, " --spp %.0f", ceil(entry->spp));
    fprintf(file, " --size %dx%d --seed %" PRIu64, ty_image_width(entry->image), ty_image_height(entry->image), seed);
    for (int i = 0; comparison->overrides != NULL && i < comparison->overrides->count; ++i) {
        fputs(" -D ", file);
        print_word(file, comparison->overrides->items[i]);
    }
    if (reference) fputs(" --aov variance,samples", file);
    fprintf(file, " -o %s.exr", entry->name);
}

char* cli_render_command(const cli_comparison* comparison, const cli_compared* entry, uint64_t seed) {
    cli_text text;
    if (!cli_text_open(&text)) return NULL;
    print_command(text.file, comparison, entry, seed);
    return cli_text_close(&text);
}
