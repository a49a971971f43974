/* Text from outside on its way to a terminal. */
#include "cli/text.h"

void cli_print_text(FILE* file, const char* text, int width) {
    int length = 0;
    for (const char* c = text; *c != '\0'; ++c, ++length) {
        const unsigned char code = (unsigned char)*c;
        putc(code < 0x20 || code == 0x7f ? '?' : code, file);
    }
    for (; length < width; ++length) putc(' ', file);
}

void cli_print_message(const char* text) {
    fputs("tyndall: ", stderr);
    cli_print_text(stderr, text, 0);
    putc('\n', stderr);
}
