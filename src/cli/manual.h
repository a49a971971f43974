/* What --help prints and manual pages hold, made from the tables that options are parsed by. */
#ifndef TY_CLI_MANUAL_H
#define TY_CLI_MANUAL_H

#include "cli/options.h"
#include "cli/text_file.h"

#include <stdio.h>

/* Prints what a command does; path: to this file instead of stdout, or NULL. CLI_DONE, or CLI_FAILED after a message.
 */
int cli_print_help(const cli_syntax* syntax, cli_help_form form, const char* path);

/* The parts of such texts, for `tyndall help`. */

extern const char* const cli_exit_statuses;

/* The options that are listed. */
void cli_print_options(FILE* file, cli_help_form form, const cli_option* options, int count);
void cli_print_common_options(FILE* file, cli_help_form form);
/* The first lines of a manual page: its header, its name and what it is. page: "render", or NULL for tyndall itself. */
void cli_print_man_name(FILE* file, const char* page, const char* summary);
/* A script of bash: its start, a function that says what may follow in a command line of one command, and its end. */
void cli_print_completion_start(FILE* file);
void cli_print_completion(FILE* file, const cli_syntax* syntax);
void cli_print_completion_end(FILE* file, cli_words_fn print_commands);
/* Paragraphs as roff, in which lines that begin with a blank stay as they are. */
void cli_print_man_text(FILE* file, const char* text);
/* Prints to a file, whole or not at all, or to stdout where path is NULL. CLI_DONE, or CLI_FAILED after a message. */
int cli_write_page(const char* path, cli_print_fn print, const void* user);

#endif
