/* index.html of a folder of figures. */
#ifndef TY_FIGURES_INDEX_PAGE_H
#define TY_FIGURES_INDEX_PAGE_H

#include <stdio.h>
#include <tyndall/base.h>

/* A cli_print_fn; user is a figure_summary. The page needs only the figures' files beside it. */
ty_result figure_print_index_page(ty_context* context, FILE* file, const void* user);

#endif
