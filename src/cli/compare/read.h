/* Reading and naming the images of a comparison. */
#ifndef TY_CLI_COMPARE_READ_H
#define TY_CLI_COMPARE_READ_H

#include "cli/compare/comparison.h"

/* Reads an image and its metadata. */
int cli_read_compared(cli_session* session, const char* path, cli_compared* out);
/* Sets a unique name for the next entry, from a method or from a path without folder and extension. */
void cli_choose_name(const cli_comparison* comparison, const char* source, char out[CLI_COMPARE_NAME]);

#endif
