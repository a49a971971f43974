/* Output of untrusted text. */
#include "cli/text/text.h"

#include <stdlib.h>
#include <string.h>

void cli_print_text(FILE* file, const char* text, int width) {
    int length = 0;
    for (const char* c = text; *c != '\0'; ++c, ++length) {
        const unsigned char code = (unsigned char)*c;
        putc(code < 0x20 || code == 0x7f ? '?' : code, file);
    }
    for (; length < width; ++length) putc(' ', file);
}

static char visible(char c) {
    return (unsigned char)c < 0x20 || c == 0x7f ? '?' : c;
}

void cli_print_html(FILE* file, const char* text) {
    for (const char* c = text; *c != '\0'; ++c) switch (*c) {
        case '&': fputs("&amp;", file); break;
        case '<': fputs("&lt;", file); break;
        case '>': fputs("&gt;", file); break;
        case '"': fputs("&quot;", file); break;
        case '\'': fputs("&#39;", file); break;
        default: fputc(visible(*c), file);
        }
}

/* Characters that end a table cell or start markup. */
void cli_print_markdown(FILE* file, const char* text) {
    for (const char* c = text; *c != '\0'; ++c) {
        if (strchr("|*<`\\[", *c) != NULL) fputc('\\', file);
        fputc(visible(*c), file);
    }
}

static _Thread_local char* kept;
static _Thread_local size_t kept_size;

void cli_keep_messages(char* text, size_t size) {
    kept = text;
    kept_size = size;
    if (text != NULL) text[0] = '\0';
}

bool cli_keeps_messages(void) {
    return kept != NULL;
}

void cli_print_message(const char* text) {
    if (kept != NULL) {
        if (kept[0] == '\0') snprintf(kept, kept_size, "%s", text);
        return;
    }
    fputs("tyndall: ", stderr);
    cli_print_text(stderr, text, 0);
    putc('\n', stderr);
}

void cli_append_word(char** text, size_t* size, const char* word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=,-+";
    const bool quoted = word[0] == '\0' || strspn(word, plain) != strlen(word);
    const size_t needed = *size + 4 * strlen(word) + 4;
    char* longer = realloc(*text, needed);
    if (longer == NULL) return;
    *text = longer;
    if (*size > 0) longer[(*size)++] = ' ';
    if (quoted) longer[(*size)++] = '\'';
    for (const char* at = word; *at != '\0'; ++at) {
        if (*at == '\'') {
            memcpy(longer + *size, "'\\''", 4);
            *size += 4;
        } else {
            longer[(*size)++] = *at;
        }
    }
    if (quoted) longer[(*size)++] = '\'';
    longer[*size] = '\0';
}
