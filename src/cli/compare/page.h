/* report.html of `tyndall compare`: one file with everything in it. */
#ifndef TY_CLI_COMPARE_PAGE_H
#define TY_CLI_COMPARE_PAGE_H

#include "cli/compare/comparison.h"

/* A cli_print_fn; user is the cli_comparison. */
ty_result cli_print_comparison_page(ty_context* context, FILE* file, const void* user);

#endif
