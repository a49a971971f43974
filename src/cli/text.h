/* Text from outside on its way to a terminal. */
#ifndef TY_CLI_TEXT_H
#define TY_CLI_TEXT_H

#include <stdio.h>

/* Prints text with its control characters replaced by ?, so that names in files and of files can neither begin a line
 * nor steer a terminal; then blanks up to width. */
void cli_print_text(FILE* file, const char* text, int width);

/* Text on a page of HTML, also within quotes, and in Markdown, also in a table's cell. */
void cli_print_html(FILE* file, const char* text);
void cli_print_markdown(FILE* file, const char* text);

/* "tyndall: " and text, one line on stderr. */
void cli_print_message(const char* text);

#endif
