/* Images that are compared: read, and named. */
#ifndef TY_CLI_COMPARE_READ_H
#define TY_CLI_COMPARE_READ_H

#include "cli/compare/comparison.h"

/* Reads an image with what its metadata tells. */
int cli_read_compared(cli_session* session, const char* path, cli_compared* out);
/* A name of its own for the next entry, from a method or from a path without folder and extension. */
void cli_choose_name(const cli_comparison* comparison, const char* source, char out[CLI_COMPARE_NAME]);

#endif
