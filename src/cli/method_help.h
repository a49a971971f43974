/* Options of methods as help shows them, from the methods' own tables. */
#ifndef TY_CLI_METHOD_HELP_H
#define TY_CLI_METHOD_HELP_H

#include <stdio.h>

/* The keys and their documentation as a section of a manual page. */
void cli_print_man_options(FILE* file);
/* "render.dom.directions render.dom.bands ...", for the shell to complete. */
void cli_print_option_keys(FILE* file);
/* One method's options as a table of Markdown: CLI_DONE, or CLI_USAGE after a message. */
int cli_print_option_table(const char* method);

#endif
