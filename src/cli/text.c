/* Output of untrusted text. */
#include "cli/text.h"

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

void cli_print_message(const char* text) {
    fputs("tyndall: ", stderr);
    cli_print_text(stderr, text, 0);
    putc('\n', stderr);
}
