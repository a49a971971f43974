/* Output of untrusted text. */
#ifndef TY_CLI_TEXT_TEXT_H
#define TY_CLI_TEXT_TEXT_H

#include <stdbool.h>
#include <stdio.h>

/* Prints text with its control characters replaced by ?, so that names in files and of files can neither start a line
 * nor control a terminal; then pads with blanks to width. */
void cli_print_text(FILE* file, const char* text, int width);

/* Prints text escaped for HTML, also within quotes, and for Markdown, also in a table cell. */
void cli_print_html(FILE* file, const char* text);
void cli_print_markdown(FILE* file, const char* text);

/* Prints "tyndall: " and the text as one line on stderr. */
void cli_print_message(const char* text);
/* From now on this thread's messages are not printed: the first of them goes into text, without a hint at --help. NULL
 * ends that. */
void cli_keep_messages(char* text, size_t size);
bool cli_keeps_messages(void);

/* Appends a word to a command line for a shell, in single quotes where it needs them; *text begins as NULL, *size as 0,
 * and the text is freed with free(). Without memory nothing is appended. */
void cli_append_word(char** text, size_t* size, const char* word);

#endif
