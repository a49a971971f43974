/* Output of untrusted text. */
#ifndef TY_CLI_TEXT_H
#define TY_CLI_TEXT_H

#include <stdio.h>

/* Prints text with its control characters replaced by ?, so that names in files and of files can neither start a line
 * nor control a terminal; then pads with blanks to width. */
void cli_print_text(FILE* file, const char* text, int width);

/* Prints text escaped for HTML, also within quotes, and for Markdown, also in a table cell. */
void cli_print_html(FILE* file, const char* text);
void cli_print_markdown(FILE* file, const char* text);

/* Prints "tyndall: " and the text as one line on stderr. */
void cli_print_message(const char* text);

#endif
