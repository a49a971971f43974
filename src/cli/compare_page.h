/* report.html of `tyndall compare`: one file with everything in it. */
#ifndef TY_CLI_COMPARE_PAGE_H
#define TY_CLI_COMPARE_PAGE_H

#include "cli/compare_files.h"

/* Writes the page; images come from the PNGs that are in the folder already. */
ty_result cli_write_comparison_page(ty_context* context, FILE* file, const cli_comparison* comparison);

#endif
