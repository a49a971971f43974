/* The command lines that render images of a comparison again. */
#ifndef TY_CLI_COMPARE_COMMAND_LINE_H
#define TY_CLI_COMPARE_COMMAND_LINE_H

#include "cli/compare/comparison.h"

/* "tyndall render scene.json --method fld ...", as a shell takes it, to be freed; NULL when memory is short. */
char* cli_render_command(const cli_comparison* comparison, const cli_compared* entry, uint64_t seed);

#endif
