/* Help texts of the methods' options, generated from the methods' tables. */
#ifndef TY_CLI_METHODS_METHOD_HELP_H
#define TY_CLI_METHODS_METHOD_HELP_H

#include <stdio.h>

/* The keys and their documentation as a section of a manual page. */
void cli_print_man_options(FILE* file);
/* Prints "render.dom.directions render.dom.bands ..." for shell completion. */
void cli_print_option_keys(FILE* file);
/* Prints one method's options as a Markdown table: CLI_DONE, or CLI_USAGE after a message. */
int cli_print_option_table(const char* name);

#endif
