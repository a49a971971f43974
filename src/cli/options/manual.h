/* The texts of --help and of manual pages, generated from the tables of options. */
#ifndef TY_CLI_OPTIONS_MANUAL_H
#define TY_CLI_OPTIONS_MANUAL_H

#include "cli/options/options.h"
#include "cli/text/text_file.h"

#include <stdio.h>

/* Prints the help of a command; path: output file instead of stdout, or NULL. CLI_DONE, or CLI_FAILED after a message.
 */
int cli_print_help(const cli_syntax* syntax, cli_help_form form, const char* path);

/* The sections of help texts, for `tyndall help`. */

extern const char* const cli_exit_statuses;

/* The options that are listed. */
void cli_print_options(FILE* file, cli_help_form form, const cli_option* options, int count);
void cli_print_common_options(FILE* file, cli_help_form form);
/* Prints the first lines of a manual page: header, name and summary. page: "render", or NULL for tyndall itself. */
void cli_print_man_name(FILE* file, const char* page, const char* summary);
/* A bash script: its start, a completion function for one command, and its end. */
void cli_print_completion_start(FILE* file);
void cli_print_completion(FILE* file, const cli_syntax* syntax);
void cli_print_completion_end(FILE* file, cli_words_fn print_commands);
/* Prints paragraphs as roff; lines that begin with a blank are preformatted. */
void cli_print_man_text(FILE* file, const char* text);
/* Prints atomically to a file, or to stdout where path is NULL. CLI_DONE, or CLI_FAILED after a message. */
int cli_write_page(const char* path, cli_print_fn print, const void* user);

#endif
