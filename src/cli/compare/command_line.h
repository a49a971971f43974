/* Command lines that reproduce the images of a comparison. */
#ifndef TY_CLI_COMPARE_COMMAND_LINE_H
#define TY_CLI_COMPARE_COMMAND_LINE_H

#include "cli/compare/comparison.h"

/* "tyndall render scene.json --method fld ...", quoted for a shell; the caller frees it. NULL when memory is short. */
char* cli_render_command(const cli_comparison* comparison, const cli_compared* entry, uint64_t seed);

#endif
